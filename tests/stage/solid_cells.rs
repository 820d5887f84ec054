//! The solidity layer: what stays, what a scan rewrites, and the heights at which beams crossed free cells.

use bytemuck::cast_slice;
use limpid::gpu::Invocations;
use limpid::sensor::Point;
use limpid::stage::ground::stated_now;
use limpid::stage::lidar::intensity_classes::{
    INTENSITY_CLASSES, INTENSITY_CLASSES_AND_BEAMS, IntensityClassesParams, layer_params,
};
use limpid::stage::lidar::intensity_layers::{INTENSITY_LAYERS_AND_BEAMS_OF_BUFFER, SECTOR_WORDS, SECTORS};

use crate::reference::solid_cells::{Solid, crossing, keep};
use crate::stage::{intensity_classes, intensity_layers};
use crate::support::compare::{Tolerance, assert_close};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;
use crate::support::scan::point;

const HEIGHT: Tolerance =
    Tolerance { absolute: 3e-3, reason: "1/1024 m, and a slope is kept to 1e-6 of all directions" };

/// Sums and counts of the layers of a cell that is found of each class.
const NONE: [[u32; 2]; 4] = [[0, 0]; 4];
const FULL: [[u32; 2]; 4] = [[8160, 2], [0, 0], [0, 0], [0, 0]];
const WEAK: [[u32; 2]; 4] = [[1000, 2], [0, 0], [0, 0], [0, 0]];
const PANE: [[u32; 2]; 4] = [[0, 0], [2000, 2], [2000, 2], [0, 0]];

/// One lidar's scan of a single cell.
#[derive(Clone, Copy)]
struct Scan {
    layers: [[u32; 2]; 4],
    reach_m: f64,
    remembered: u32,
    tick: u32,
    sensor: u32,
}

const CROSSED: Scan = Scan { layers: NONE, reach_m: 5.0, remembered: 0, tick: 20, sensor: 0 };
const UNSEEN: Scan = Scan { reach_m: 0.0, ..CROSSED };

fn word(scan: u32, strength: u32) -> u32 {
    scan | strength << 20
}

/// What the layer holds of a cell after a scan.
fn after(before: [u32; 4], scan: Scan) -> [u32; 4] {
    let out = Fragment::new()
        .params("intensity_classes_params", &intensity_classes::params(1))
        .input("ground_now", &stated_now(0.5))
        .params("solid_cells_params", &layer_params(scan.tick, scan.sensor, 0.5))
        .input("layer_sums", &scan.layers)
        .input("sector_range", &vec![(scan.reach_m * 1024.0) as u32; 2 * SECTORS as usize])
        .changed("remembered", &[scan.remembered << 20])
        .changed("solid_cells", &[before])
        .output("obstacle_value", 1)
        .output("layer_values", 4)
        .run(INTENSITY_CLASSES, Invocations::area(1, 1));
    out.words("solid_cells").try_into().unwrap()
}

/// The record of a cell.
fn record(class: u32, strength: u32, tick: u32, sensor: u32) -> [u32; 4] {
    let glass = if class == 4 { strength << 8 } else { 0 };
    [word(class, strength) | glass, tick, 0, (sensor + 1) << 24]
}

#[test]
fn truth_what_a_scan_says_is_kept_until_another_says_something() {
    if skipped() {
        return;
    }
    let solid = after([0; 4], Scan { layers: FULL, ..CROSSED });
    assert_eq!(solid, record(2, 4080, 20, 0));
    assert_eq!(after(solid, Scan { tick: 30, ..UNSEEN }), solid, "nothing was said");
    let free = after(solid, Scan { tick: 30, ..CROSSED });
    assert_eq!(free, record(1, 0, 30, 0), "it went away");
    assert_eq!(after(free, Scan { tick: 29, layers: FULL, ..CROSSED }), free, "a late scan");
    assert_eq!(after(free, Scan { tick: 30, layers: WEAK, ..CROSSED }), record(3, 0, 30, 0));
    assert_eq!(after([0; 4], UNSEEN), [0; 4]);
}

#[test]
fn truth_glass_fades_as_it_is_remembered_and_keeps_its_age() {
    if skipped() {
        return;
    }
    let glass = after([0; 4], Scan { layers: PANE, ..CROSSED });
    assert_eq!((glass[0] & 0xff, glass[1]), (4, 20));
    let faded = after(glass, Scan { tick: 30, remembered: 700, ..CROSSED });
    assert_eq!(faded, record(4, 700, 20, 0), "seen at tick 20");
    assert_eq!(after(faded, Scan { tick: 40, ..UNSEEN }), [0; 4], "forgotten, and nothing else is known");
    assert_eq!(after(faded, Scan { tick: 40, ..CROSSED }), record(1, 0, 40, 0));
    assert_eq!(after(faded, Scan { tick: 40, sensor: 1, ..UNSEEN }), faded, "another lidar's memory");
}

#[test]
fn truth_of_two_lidars_solid_wins_and_glass_is_not_free() {
    if skipped() {
        return;
    }
    let other = |layers| Scan { layers, tick: 30, sensor: 1, ..CROSSED };
    let (solid, glass) = (record(2, 4080, 20, 0), record(4, 900, 20, 0));
    assert_eq!(after(solid, other(WEAK)), solid);
    assert_eq!(after(solid, other(PANE)), solid);
    assert_eq!(after(solid, other(NONE)), record(1, 0, 30, 1), "free at the newest");
    assert_eq!(after(glass, other(NONE)), glass);
    assert_eq!(after(glass, other(WEAK)), glass);
    assert_eq!(after(glass, other(FULL)), record(2, 4080, 30, 1));
}

#[test]
fn twin_over_random_scans_at_all_sizes() {
    if skipped() {
        return;
    }
    for (side, seed) in [(1, 1), (7, 2), (8, 3), (9, 4), (17, 5)] {
        let (mut random, cells) = (Random(seed), side * side);
        let mut ring = vec![[0_u32; 4]; cells];
        let mut twins = vec![None; cells];
        let mut classes = [0; 5];
        for turn in 0..6 {
            let (tick, sensor) = (turn * 10 + 100 - 25 * u32::from(turn == 3), random.below(2));
            let kinds: Vec<u32> = (0..cells).map(|_| random.below(4)).collect();
            let layers: Vec<[[u32; 2]; 4]> =
                kinds.iter().map(|&kind| [NONE, FULL, WEAK, PANE][kind as usize]).collect();
            let params = layer_params(tick, sensor, 0.5);
            let slots = IntensityClassesParams {
                origin_slot_x: (3 % side) as u32,
                origin_slot_y: (5 % side) as u32,
                forget: 1,
                ..intensity_classes::params(side)
            };
            let reach_m = if u32::is_multiple_of(turn, 2) { 100.0 } else { 0.0 };
            let out = Fragment::new()
                .params("intensity_classes_params", &slots)
                .input("ground_now", &stated_now(0.5))
                .params("solid_cells_params", &params)
                .input("layer_sums", &layers)
                .input("sector_range", &vec![(reach_m * 1024.0) as u32; 2 * SECTORS as usize])
                .changed("remembered", &vec![0_u32; cells])
                .changed("solid_cells", &ring)
                .output("obstacle_value", cells)
                .output("layer_values", 4 * cells)
                .run(INTENSITY_CLASSES, Invocations::area(side as u32, side as u32));
            ring = cast_slice(out.words("solid_cells")).to_vec();
            for (cell, &kind) in kinds.iter().enumerate() {
                let crossed = u32::from(reach_m > 0.0);
                let (class, strength) = [(crossed, 0), (2, 4080), (3, 0), (4, 1000)][kind as usize];
                let now = Solid { class, strength, tick, sensor };
                let slot = (cell / side + 5) % side * side + (cell % side + 3) % side;
                twins[slot] = keep(twins[slot], now, class > 0);
                let want = twins[slot].map_or([0; 4], |s| record(s.class, s.strength, s.tick, s.sensor));
                assert_eq!(ring[slot], want, "side {side}, turn {turn}, cell {cell}");
                classes[want[0] as usize & 7] += 1;
            }
        }
        assert!(side < 7 || classes.iter().all(|count| *count > 0), "{classes:?}");
    }
}

/// A fan of beams: one slope a ring, and a range for each azimuth.
fn beams(slopes: &[f64], range_m: impl Fn(f64, usize) -> f64) -> Vec<Point> {
    (0..1440)
        .flat_map(|step| {
            let azimuth = (f64::from(step) + 0.5) * std::f64::consts::TAU / 1440.0;
            let at = |(ring, slope): (usize, &f64)| {
                let range = range_m(azimuth, ring);
                point([range * azimuth.cos(), range * azimuth.sin(), range * slope], 0.0)
            };
            slopes.iter().enumerate().map(at).collect::<Vec<_>>()
        })
        .collect()
}

/// `beam_reach` of those points.
fn reach_of(points: &[Point]) -> Vec<u32> {
    let bytes: Vec<u32> =
        cast_slice::<Point, u8>(points).chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
    let out = Fragment::new()
        .input("points", &bytes)
        .params("intensity_layers_params", &intensity_layers::params(points.len()))
        .input("ground_now", &stated_now(0.5))
        .changed("layer_sums", &vec![0_u32; 12 * 12 * 5 * 2])
        .changed("sector_range", &vec![0_u32; 2 * SECTORS as usize])
        .changed("beam_reach", &vec![0_u32; (SECTORS * SECTOR_WORDS) as usize])
        .run(INTENSITY_LAYERS_AND_BEAMS_OF_BUFFER, Invocations::line(points.len() as u32));
    out.words("beam_reach").to_vec()
}

/// Records of free cells around a lidar in the middle that is `height_m` above the ground.
fn crossed_cells(side: usize, beam_reach: &[u32], height_m: f32) -> Vec<[u32; 4]> {
    let cells = side * side;
    let out = Fragment::new()
        .params("intensity_classes_params", &intensity_classes::params(side))
        .input("ground_now", &stated_now(0.5))
        .params("solid_cells_params", &layer_params(7, 2, height_m))
        .input("layer_sums", &vec![[0_u32; 2]; 4 * cells])
        .input("sector_range", &vec![u32::MAX; 2 * SECTORS as usize])
        .input("beam_reach", beam_reach)
        .changed("remembered", &vec![0_u32; cells])
        .changed("solid_cells", &vec![[0_u32; 4]; cells])
        .output("obstacle_value", cells)
        .output("layer_values", 4 * cells)
        .run(INTENSITY_CLASSES_AND_BEAMS, Invocations::area(side as u32, side as u32));
    cast_slice(out.words("solid_cells")).to_vec()
}

/// Lowest and highest crossing and largest gap of a record.
fn heights(record: &[u32; 4]) -> Option<[f64; 3]> {
    let height = |steps: u32| f64::from(steps) / 1024.0 - 32.0;
    (record[2] != 0).then(|| {
        [height(record[2] & 0xffff), height(record[2] >> 16), f64::from(record[3] & 0xffff) / 1024.0]
    })
}

#[test]
fn twin_of_the_heights_at_which_beams_crossed() {
    if skipped() {
        return;
    }
    // Rings 2 degrees apart, as of a sensor with 16 of them; some end early to one side.
    let slopes: Vec<f64> = (0..16).map(|ring| f64::to_radians(f64::from(ring) * 2.0 - 15.0).tan()).collect();
    let range_m =
        |azimuth: f64, ring: usize| if azimuth < 2.0 && ring.is_multiple_of(3) { 0.31 } else { 4.0 };
    let beam_reach = reach_of(&beams(&slopes, range_m));
    let side = 20;
    let cells = crossed_cells(side, &beam_reach, 0.7);
    let (mut got, mut want) = (Vec::new(), Vec::new());
    for (cell, record) in cells.iter().enumerate() {
        let at = |index: usize| (index as f64 + 0.5) * 0.1 - 0.05 * side as f64;
        let (x, y) = (at(cell % side), at(cell / side));
        let azimuth = y.atan2(x).rem_euclid(std::f64::consts::TAU);
        let range = x.hypot(y);
        // Not where rings begin to end early, nor where they do.
        if [0.0, 2.0].iter().any(|edge| (azimuth - edge).abs() < 0.05) || (range + 0.1 - 0.31).abs() < 0.01 {
            continue;
        }
        let all: Vec<(f64, f64)> = slopes
            .iter()
            .enumerate()
            .map(|(ring, slope)| (range_m(azimuth, ring), range_m(azimuth, ring) * slope))
            .collect();
        got.extend(heights(record).expect("beams crossed every cell"));
        want.extend(crossing(&all, range, range + 0.1, 0.7).unwrap());
        assert_eq!((record[0], record[1], record[3] >> 24), (1, 7, 3));
    }
    assert!(got.len() > 900, "{}", got.len());
    assert_close("heights", &got, &want, HEIGHT);
}

#[test]
fn truth_steep_beams_none_and_one() {
    if skipped() {
        return;
    }
    let none = crossed_cells(3, &vec![0; (SECTORS * SECTOR_WORDS) as usize], 0.5);
    assert!(none.iter().all(|record| heights(record).is_none() && record[1] == 7), "free all the same");
    let one = crossed_cells(5, &reach_of(&beams(&[0.5], |_, _| 9.0)), 0.5);
    let [low, high, gap] = heights(&one[22]).unwrap();
    // Two cells of 0.1 m along y: half a metre up, and half of 0.2 m.
    assert!((low - 0.6).abs() < 3e-3 && low == high && gap == 0.0, "{low} {high} {gap}");
    let steep = crossed_cells(5, &reach_of(&beams(&[-40.0, 40.0], |_, _| 9.0)), 0.5);
    let [low, high, gap] = heights(&steep[22]).unwrap();
    assert!(
        (low + 7.5).abs() < 0.1 && (high - 8.5).abs() < 0.1 && (gap - 16.0).abs() < 0.2,
        "{low} {high} {gap}"
    );
}

#[test]
fn poison_gives_heights_in_their_bits() {
    if skipped() {
        return;
    }
    let nan = [f64::NAN, f64::INFINITY, 1e30, -1e30, 0.0];
    let points: Vec<Point> =
        nan.iter().flat_map(|&a| nan.iter().map(move |&b| point([a, 1.0, b], 1.0))).collect();
    assert_eq!(reach_of(&points).len(), (SECTORS * SECTOR_WORDS) as usize);
    for record in crossed_cells(9, &vec![u32::MAX; (SECTORS * SECTOR_WORDS) as usize], f32::MAX) {
        assert!(
            record[3] >> 24 == 3 && record[1] == 7 && record[2] & 0xffff <= record[2] >> 16,
            "{record:x?}"
        );
    }
}
