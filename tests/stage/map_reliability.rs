//! Which cells are obstacles by what was seen of them and around them.

use glam::DVec2;
use limpid::Config;
use limpid::gpu::Invocations;
use limpid::sensor::{CameraModel, Distortion};
use limpid::stage::camera::map_reliability::{
    HIDDEN, INPUTS, MAP_RELIABILITY, MapReliability, MapReliabilityParams, SHIPPED,
};
use limpid::stage::camera::update::evidence_params;

use crate::reference::map_reliability::{Evidence, Look, Looks, inputs, logit};
use crate::stage::update::SCALE;
use crate::support::compare::{Tolerance, assert_close};
use crate::support::gpu::{Fragment, Outputs, skipped};
use crate::support::random::Random;

const SINGLE: Tolerance = Tolerance { absolute: 1e-4, reason: "f32, log2 and pow of the driver" };

const SHARE_ONE: f64 = 65535.0;
const ORIGIN_SLOT: [u32; 2] = [3, 1];
const AT_M: DVec2 = DVec2::new(0.31, -0.42);
const FOCAL_PX: f64 = 400.0;

fn camera() -> CameraModel {
    let (width, height) = (640, 480);
    CameraModel { width, height, fx: 320.0, fy: 500.0, cx: 320.0, cy: 240.0, distortion: Distortion::None }
}

/// A network whose weights are all different.
fn network(bias: f32) -> MapReliability {
    let inner = (0..HIDDEN * (INPUTS.len() + 1)).map(|at| ((at * 7 % 23) as f32 - 11.0) * 0.02).collect();
    let outer = (0..HIDDEN).map(|at| at as f32 * 0.4 - 3.2).collect();
    MapReliability { inner, outer, bias, release: 0.5 }
}

/// A cell before the pass, and what the frame shows of it; `update` has taken it in already.
#[derive(Debug, Clone, Copy, Default)]
struct Cell {
    evidence: [f64; 2],
    looks: Looks,
    last_tick: u32,
    was_obstacle: bool,
    seen: Option<Look>,
    /// In steps of 1/1024 m and of 1/65536 m.
    low: u32,
    top: u32,
}

/// The state that `update` left: occupied, to be replaced.
const OCCUPIED: u32 = 2;

/// The ring's records of the cells of a window: cells, cell_marks, cell_looks.
fn ring_of(side: u32, tick: u32, cells: &[Cell]) -> Vec<([u32; 4], [u32; 2], [f32; 8])> {
    let slot = |i: usize| {
        let [x, y] = [i as u32 % side + ORIGIN_SLOT[0], i as u32 / side + ORIGIN_SLOT[1]].map(|at| at % side);
        (y * side + x) as usize
    };
    let mut ring = vec![([0_u32; 4], [0_u32; 2], [0.0_f32; 8]); cells.len()];
    for (i, cell) in cells.iter().enumerate() {
        let [support, opposed] = cell.evidence.map(|value| (value as f32).to_bits());
        let l = cell.looks;
        let [a, b, c, d, e, f] =
            [l.hit, l.through, l.strength, l.reliability, l.floor, l.all].map(|sum| sum as f32);
        let words =
            [a, b, c, d, e, f, f32::from_bits(cell.last_tick), f32::from(u8::from(cell.was_obstacle))];
        ring[slot(i)] =
            ([support, OCCUPIED | 0x500, opposed, cell.top], [tick, cell.low | 0x1ff_0000], words);
    }
    ring
}

fn run(side: u32, tick: u32, timed: bool, cells: &[Cell], network: &MapReliability) -> Outputs {
    let ring = ring_of(side, tick, cells);
    let hits = |cell: &Cell| match cell.seen {
        Some(Look { hits: Some((n, sum)), .. }) => {
            [n as u32, (sum * f64::from(SCALE)).round() as u32, 20_000, !9000]
        }
        Some(Look { floor: true, .. }) => [0, 0, 1, 0],
        _ => [0; 4],
    };
    let flags = |cell: &Cell| match cell.seen {
        Some(Look { hits: Some(_), .. }) => OCCUPIED | 4,
        Some(_) => OCCUPIED | 8,
        None => OCCUPIED,
    };
    let share = |cell: &Cell| (cell.seen.unwrap_or_default().share * SHARE_ONE).round() as u32;
    let params = MapReliabilityParams {
        side,
        origin_slot_x: ORIGIN_SLOT[0] % side,
        origin_slot_y: ORIGIN_SLOT[1] % side,
        tick,
        weight_scale: SCALE as f32,
        release: network.release,
        pad_x: 0,
        pad_y: 0,
    };
    let weights: Vec<f32> = network.words(0.0).chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
    Fragment::new()
        .params("map_reliability_params", &params)
        .params("evidence_params", &evidence_params(&Config::default(), &camera(), AT_M))
        .input("cell_hits", &cells.iter().map(hits).collect::<Vec<_>>())
        .input("seen_through", &cells.iter().map(share).collect::<Vec<_>>())
        .changed("cells", &ring.iter().map(|cell| cell.0).collect::<Vec<_>>())
        .input("cell_marks", &ring.iter().map(|cell| cell.1).collect::<Vec<_>>())
        .changed("cell_looks", &ring.iter().map(|cell| cell.2).collect::<Vec<_>>())
        .changed("state", &cells.iter().map(flags).collect::<Vec<_>>())
        .input("map_reliability_weights", &weights)
        .output("map_reliability_inputs", INPUTS.len() * cells.len())
        .constants(&[("timed", timed), ("keep_inputs", true)])
        .run(MAP_RELIABILITY, Invocations::area(side, side))
}

/// Offset of a cell of the window from the camera.
fn offset_m(i: usize, side: u32) -> DVec2 {
    DVec2::new(f64::from(i as u32 % side) + 0.5, f64::from(i as u32 / side) + 0.5) * 0.05 - AT_M
}

fn random_cell(random: &mut Random) -> Cell {
    let mut unit = || f64::from(random.unit());
    let all = 1.0 + 9.0 * unit();
    let looks = Looks {
        hit: all * unit(),
        through: all * unit(),
        strength: all * unit(),
        reliability: all * unit(),
        floor: all * unit(),
        all,
    };
    let share = (unit() * SHARE_ONE).floor() / SHARE_ONE;
    let mean_r = (2048.0 + 2048.0 * unit()).floor() / 4096.0;
    let evidence = [(8.75 * unit() * unit()).max(0.0), 5.0 * unit() * unit()];
    let n = (1.0 + 12.0 * unit()).floor();
    let seen = match random.below(10) {
        0..6 => Some(Look { hits: Some((n, n * mean_r)), share, floor: false }),
        6..8 => Some(Look { hits: None, share: share.max(1.0 / SHARE_ONE), floor: random.chance(0.5) }),
        _ => None,
    };
    let looks = if random.chance(0.1) { Looks::default() } else { looks };
    Cell {
        evidence: evidence.map(|value| f64::from(value as f32)),
        looks,
        last_tick: if looks.all == 0.0 { 0 } else { 90 + random.below(10) },
        was_obstacle: random.chance(0.5),
        seen,
        low: random.below(3000),
        top: 2 + random.below(150_000),
    }
}

/// The twin's inputs, and whether the network is asked at all.
fn twin(cells: &[Cell], side: u32, tick: u32, timed: bool, i: usize) -> Option<[f64; INPUTS.len()]> {
    let cell = cells[i];
    let look = cell.seen?;
    let counts = match timed && cell.looks.all > 0.0 {
        true => (f64::from(tick - cell.last_tick) * 0.01 * 30.0).min(1.0),
        false => 1.0,
    };
    let offset = offset_m(i, side);
    let enough = (7.5e-5 * (FOCAL_PX / offset.length().max(0.3)).powi(2)).max(8.0);
    let looks = cell.looks.with(look, enough, 6.0, counts);
    let evidence: Vec<[f64; 2]> = cells.iter().map(|cell| cell.evidence).collect();
    let heights = [f64::from(cell.low) / 1024.0, f64::from(cell.top - 2) / 65536.0];
    let at = [i64::from(i as u32 % side), i64::from(i as u32 / side)];
    let evidence = Evidence { side: side as usize, cells: &evidence };
    (cell.evidence[0] >= 0.22).then(|| inputs(&evidence, at, offset, heights, looks))
}

/// The state of a cell that was looked at at tick 100, by the network's sum, and how far what decided was from its threshold.
fn state_of(cell: &Cell, sum: Option<f64>, timed: bool) -> (u32, f64) {
    let counts = if timed && cell.looks.all > 0.0 { f64::from(100 - cell.last_tick) * 0.3 } else { 1.0 };
    let left = 0.9_f64.powf(counts.min(1.0));
    let hit = cell.seen.is_some_and(|look| look.hits.is_some());
    let hits = left * cell.looks.hit + if hit { (1.0 - left) / 0.1 } else { 0.0 };
    let least = if cell.was_obstacle { -0.5 } else { 0.0 };
    let margin = sum.map_or(1.0, |sum| (sum - least).abs()).min((hits - 1.5).abs());
    let free = cell.evidence[1] >= 0.002 && cell.evidence[0] < 1.75 * cell.evidence[1];
    let is_obstacle = hits >= 1.5 && sum.is_some_and(|sum| sum >= least);
    let rest = if free { 1 } else { 0 };
    (if is_obstacle { OCCUPIED } else { rest }, margin)
}

#[test]
fn twin_of_random_cells_at_edge_sizes() {
    if skipped() {
        return;
    }
    for (side, timed) in [(1, false), (7, false), (16, true), (33, false)] {
        let mut random = Random(60 + u64::from(side));
        let cells: Vec<Cell> = (0..side * side).map(|_| random_cell(&mut random)).collect();
        // At which half of the cells that the network is asked for are obstacles.
        let asked = (0..cells.len()).filter_map(|i| twin(&cells, side, 100, timed, i));
        let mut sums: Vec<f64> = asked.map(|inputs| logit(&inputs, &network(0.0))).collect();
        sums.sort_by(f64::total_cmp);
        let network = network(-sums.get(sums.len() / 2).copied().unwrap_or(0.0) as f32);
        let out = run(side, 100, timed, &cells, &network);
        let (got, states) = (out.floats("map_reliability_inputs"), out.words("state"));
        let mut found = [0; 3];
        for (i, cell) in cells.iter().enumerate() {
            let own = &got[i * INPUTS.len()..][..INPUTS.len()];
            let want = twin(&cells, side, 100, timed, i);
            if cell.seen.is_none() {
                assert_eq!(states[i], OCCUPIED, "cells that nobody looked at stay as they are");
                continue;
            }
            let expected = want.unwrap_or([0.0; INPUTS.len()]);
            for (at, name) in INPUTS.iter().enumerate() {
                assert_close(
                    &format!("{name} of {i}, side {side}"),
                    &own[at..=at],
                    &expected[at..=at],
                    SINGLE,
                );
            }
            let sum = want.map(|inputs| logit(&inputs, &network));
            let (want, margin) = state_of(cell, sum, timed);
            if margin > 1e-3 {
                assert_eq!(states[i] & 3, want, "cell {i}, side {side}: {sum:?}");
                found[want as usize] += 1;
            }
        }
        assert!(side < 33 || found.iter().all(|cells| *cells > 30), "{found:?}");
    }
}

#[test]
fn truth_what_is_kept_of_looks_and_how_obstacles_are_given_up() {
    if skipped() {
        return;
    }
    let sure = Look { hits: Some((60.0, 60.0)), share: 0.25, floor: false };
    let looks = Looks { hit: 1.0, strength: 1.0, reliability: 1.0, all: 1.0, ..Looks::default() };
    let cell = Cell { evidence: [2.0, 1.0], looks, last_tick: 90, seen: Some(sure), ..Cell::default() };
    let of = |cell: Cell, bias: f32| {
        let out = run(1, 100, false, &[cell], &MapReliability { outer: vec![0.0; HIDDEN], ..network(bias) });
        (out.words("state")[0] & 3, out.floats("cell_looks"), out.words("cells").to_vec())
    };
    let (state, looks, cells) = of(cell, 0.1);
    assert_eq!(state, OCCUPIED);
    assert_close("looks", &looks[..6], &[1.9, 0.25, 1.9, 1.9, 0.0, 1.9], SINGLE);
    assert_eq!((looks[6].to_bits(), looks[7]), (100, 1.0));
    assert_eq!(cells, [2.0_f32.to_bits(), 0x500 | OCCUPIED, 1.0_f32.to_bits(), 0], "evidence stays");
    // Under 0 a new cell is none; one that was an obstacle stays one until `release` under 0.
    let was = Cell { was_obstacle: true, ..cell };
    assert_eq!([of(cell, -0.1).0, of(was, -0.4).0, of(was, -0.6).0], [0, OCCUPIED, 0]);
    // Free where what is against it outweighs what is for it; with next to nothing for it the network is not asked.
    let against = Cell { evidence: [2.0, 1.2], ..cell };
    assert_eq!(of(against, -0.6).0, 1);
    let once = Cell { looks: Looks::default(), ..cell };
    assert_eq!(of(once, 5.0).0, 0, "seen once");
    let faint = Cell { evidence: [0.21, 0.0], was_obstacle: true, ..cell };
    assert_eq!(of(faint, 5.0).0, 0);
}

#[test]
fn weight_files_of_another_kind_are_refused() {
    let shipped = MapReliability::shipped().unwrap();
    assert_eq!(shipped.inner.len(), HIDDEN * (INPUTS.len() + 1));
    let refused = |bytes: &[u8]| MapReliability::from_bytes(bytes).unwrap_err().to_string();
    assert!(refused(&SHIPPED[..SHIPPED.len() / 2]).contains("no safetensors file"));
    assert!(refused(limpid::stage::lidar::solidity::SHIPPED).contains("`format`"));
    let changed = |from: &[u8], to: &[u8]| {
        let at = SHIPPED.windows(from.len()).position(|window| window == from).unwrap();
        let mut bytes = SHIPPED.to_vec();
        bytes[at..at + to.len()].copy_from_slice(to);
        bytes
    };
    assert!(refused(&changed(b"through,", b"Through,")).contains("`inputs`"));
    assert!(refused(&changed(b"\"release\": \"0.", b"\"release\": \"-.")).contains("`release`"));
}
