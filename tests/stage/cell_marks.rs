//! Cells seen by several cameras: when, by whom and how, and occupancy by the time between looks.

use bytemuck::cast_slice;
use limpid::Config;
use limpid::gpu::Invocations;
use limpid::stage::camera::update::{UPDATE, mark_params};

use crate::reference::cell_marks::{Look, Marked};
use crate::stage::update::{self, SCALE};
use crate::support::compare::{Tolerance, assert_close};
use crate::support::gpu::{Fragment, Outputs, skipped};
use crate::support::random::Random;

const OCCUPANCY: Tolerance =
    Tolerance { absolute: 2e-6, reason: "f32, and exp2 of the driver to a few units" };

/// A frame.
#[derive(Clone, Copy)]
struct At {
    tick: u32,
    sensor: u32,
    timed: bool,
}

/// (cells, cell_marks).
type Ring = (Vec<[u32; 4]>, Vec<[u32; 2]>);

fn encode(look: Look) -> ([u32; 4], u32) {
    let steps = |m: f64| (m * 65536.0).round() as u32 + 2;
    match look {
        Look::Hit { mean_r, low_m, high_m } => {
            ([3, (mean_r * f64::from(3 * SCALE)).round() as u32, steps(high_m), !steps(low_m)], 0)
        }
        Look::Seen => ([0; 4], 1),
        Look::Nothing => ([0; 4], 0),
    }
}

fn run(side: u32, ring: &Ring, at: At, looks: &[Look]) -> Outputs {
    let (hits, seen): (Vec<[u32; 4]>, Vec<u32>) = looks.iter().map(|&look| encode(look)).unzip();
    Fragment::new()
        .params("update_params", &update::params(&Config::default(), side, [2 % side, 5 % side]))
        .params("cell_marks_params", &mark_params(at.tick, at.sensor, 0.85))
        .input("cell_hits", &hits)
        .input("seen_through", &seen)
        .changed("cells", &ring.0)
        .changed("cell_marks", &ring.1)
        .output("evidence", looks.len())
        .output("occupancy", looks.len())
        .output("state", looks.len())
        .constants(&[("timed", at.timed), ("lowest", true)])
        .run(UPDATE, Invocations::area(side, side))
}

fn ring(out: &Outputs) -> Ring {
    (cast_slice(out.words("cells")).to_vec(), cast_slice(out.words("cell_marks")).to_vec())
}

fn empty(cells: usize) -> Ring {
    (vec![[0; 4]; cells], vec![[0; 2]; cells])
}

/// Tick, lowest hit in metres, mean R and sensor of a record.
fn mark([tick, how]: [u32; 2]) -> (u32, f64, f64, u32) {
    (tick, f64::from(how & 0xffff) / 1024.0, f64::from(how >> 16 & 0xff) / 255.0, how >> 24)
}

const HIT: Look = Look::Hit { mean_r: 1.0, low_m: 0.5, high_m: 0.75 };

#[test]
fn truth_ticks_sensors_lowest_hits_and_reliability() {
    if skipped() {
        return;
    }
    let at = |tick, sensor| At { tick, sensor, timed: false };
    let step = |ring: &Ring, at, look| self::ring(&run(1, ring, at, &[look]));
    let first = step(&empty(1), at(7, 2), HIT);
    assert_eq!(mark(first.1[0]), (7, 0.5, 1.0, 3));
    let lower = step(&first, at(9, 0), Look::Hit { mean_r: 0.4, low_m: 0.25, high_m: 0.3 });
    assert_eq!(mark(lower.1[0]), (9, 0.25, 0.4, 1));
    let higher = step(&lower, at(11, 0), Look::Hit { mean_r: 0.8, low_m: 1.5, high_m: 1.6 });
    assert_eq!(mark(higher.1[0]), (11, 0.25, 0.8, 1), "the lowest of all");
    assert_eq!(step(&higher, at(13, 0), Look::Nothing), higher, "unseen keeps its bits");
    let free = step(&higher, at(13, 1), Look::Seen);
    assert_eq!(mark(free.1[0]), (13, 0.0, 0.0, 2), "what was hit is gone");
    assert_eq!(mark(step(&free, at(15, 1), HIT).1[0]).1, 0.5, "hits anew");
    let occupied = (0..9).fold(empty(1), |ring, n| step(&ring, at(n + 1, 0), HIT));
    let seen = step(&occupied, at(20, 1), Look::Seen);
    assert_eq!(mark(seen.1[0]), (20, 0.5, 1.0, 2), "still occupied, by hits of that height");
}

#[test]
fn truth_a_late_frame_changes_nothing() {
    if skipped() {
        return;
    }
    let now = ring(&run(1, &empty(1), At { tick: 50, sensor: 0, timed: true }, &[HIT]));
    for look in [Look::Seen, HIT] {
        let late = run(1, &now, At { tick: 49, sensor: 1, timed: true }, &[look]);
        assert_eq!(ring(&late), now);
        assert_eq!((late.floats("evidence")[0], late.words("state")[0]), (-1.0, 0));
        assert_ne!(
            ring(&run(1, &now, At { tick: 50, sensor: 1, timed: false }, &[look])),
            now,
            "the control"
        );
    }
}

#[test]
fn truth_two_cameras_that_overlap_forget_as_fast_as_one() {
    if skipped() {
        return;
    }
    let after = |ticks: &[u32]| {
        let ring = ticks.iter().fold(empty(1), |ring, &tick| {
            let look = if tick == 1 { HIT } else { Look::Seen };
            self::ring(&run(1, &ring, At { tick, sensor: tick % 2, timed: true }, &[look]))
        });
        f32::from_bits(ring.0[0][0])
    };
    let (one, two) = (after(&[1, 11, 21]), after(&[1, 6, 11, 16, 21]));
    // 0.15 after the first look, and 0.2 s later 0.85^6 of that.
    assert_close("p", &[one, two], &[0.15 * 0.85_f64.powi(6); 2], OCCUPANCY);
}

#[test]
fn twin_of_random_looks_at_all_sizes() {
    if skipped() {
        return;
    }
    for (side, timed) in [(1, true), (7, false), (8, true), (9, true), (17, true)] {
        let (mut random, cells) = (Random(90 + u64::from(side)), (side * side) as usize);
        let (mut kept, mut twins) = (empty(cells), vec![Marked::default(); cells]);
        let mut tick = 1;
        for _ in 0..24 {
            tick = (tick + random.below(6)).saturating_sub(1).max(1);
            let sensor = random.below(2);
            let looks: Vec<Look> = (0..cells)
                .map(|_| match random.below(10) {
                    0..6 => Look::Hit {
                        mean_r: f64::from(random.below(200) + 56) / 256.0,
                        low_m: f64::from(random.below(64)) / 64.0,
                        high_m: 1.0 + f64::from(random.below(64)) / 64.0,
                    },
                    6..8 => Look::Seen,
                    _ => Look::Nothing,
                })
                .collect();
            let out = run(side, &kept, At { tick, sensor, timed }, &looks);
            kept = ring(&out);
            twins.iter_mut().zip(&looks).for_each(|(twin, &look)| twin.look(tick, sensor, timed, look));
            assert!(twins.iter().all(|twin| (twin.p - 0.7).abs() > 3e-6 && (twin.p - 0.5).abs() > 3e-6));
            let p: Vec<f64> = twins.iter().map(|twin| twin.p).collect();
            assert_close("p", &out.floats("occupancy"), &p, OCCUPANCY);
            for (cell, twin) in twins.iter().enumerate() {
                let (x, y) = (cell as u32 % side + 2, cell as u32 / side + 5);
                let slot = (y % side * side + x % side) as usize;
                let state = u32::from(twin.free) + 2 * u32::from(twin.occupied);
                assert_eq!(out.words("state")[cell] & 3, state, "side {side}, cell {cell}, {twin:?}");
                let (tick, low_m, mean_r, sensor) = mark(kept.1[slot]);
                let want = twin.last.map_or((0, 0), |(tick, sensor)| (tick, sensor + 1));
                assert_eq!((tick, sensor), want);
                assert_eq!(low_m, twin.low_m.unwrap_or(0.0), "{twin:?}");
                assert!((mean_r - twin.mean_r).abs() < 0.51 / 255.0, "{mean_r} {twin:?}");
            }
        }
    }
}

#[test]
fn poison_stays_in_its_bits() {
    if skipped() {
        return;
    }
    let poison = (vec![[u32::MAX; 4]; 4], vec![[3, u32::MAX]; 4]);
    let looks = [HIT, Look::Seen, Look::Nothing, Look::Hit { mean_r: 1e5, low_m: 6e4, high_m: 6e4 }];
    let out = run(2, &poison, At { tick: u32::MAX, sensor: 15, timed: true }, &looks);
    for [tick, how] in ring(&out).1 {
        assert!(tick == u32::MAX && how >> 24 == 16 || [tick, how] == [3, u32::MAX], "{tick} {how:x}");
    }
}
