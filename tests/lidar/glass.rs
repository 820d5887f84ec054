//! Transparent cells over time: they stay where they are in the map.

use std::f64::consts::PI;

use crate::support::scan::ScanPipeline;
use crate::support::scan::{ScanFrame, ScanOutput, by_intensity};
use glam::{DQuat, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::map::CellClass;
use limpid::sensor::Point;
use limpid::sensor::SensorPose;

use crate::support::gpu::skipped;
use crate::support::scan::{grid, open, point, posed, scan, step};

fn config() -> Config {
    Config { scan_map_size_m: 8.0, transparent_threshold: 0.05, ..by_intensity() }
}

fn pose(x: f64, y: f64, yaw: f64) -> SensorPose {
    let map_from_base = Rigid { rotation: DQuat::from_rotation_z(yaw), translation_m: DVec3::new(x, y, 0.0) };
    SensorPose { map_from_base, base_from_sensor: Rigid::IDENTITY, sweep: None }
}

/// The lidar at `pose` before a pane at x = 2 m: ring 1, horizontal, sees a patch of it; ring 0, below, does not. All around
/// stand dim posts.
fn frame(index: u64, pose: SensorPose, sees_pane: bool) -> ScanFrame {
    let mut in_map = Vec::new();
    if sees_pane {
        in_map.extend((-3..=3).map(|step| ([2.05, 0.1 * f64::from(step) + 0.05, 0.0], 60.0, 1)));
    }
    in_map.extend((0..40).map(|post| {
        let angle = f64::from(post) * PI / 20.0;
        ([3.4 * angle.cos() + 0.003, 3.4 * angle.sin() + 0.003, 0.2], 50.0, 2)
    }));
    let lidar_from_map = pose.map_from_sensor().inverse();
    let points = in_map.into_iter().map(|(at, intensity, ring)| {
        let at = lidar_from_map.transform_point(DVec3::from_array(at));
        Point { ring, ..point(at.to_array(), intensity) }
    });
    // Enough points of the two rings for their elevations, out of the map.
    let rings = (0..20).flat_map(|at| {
        let far = |ring, z| Point { ring, ..point([60.0 + f64::from(at), 1.0, z], 1.0) };
        [far(0, -6.0), far(1, 0.0), far(2, 6.0)]
    });
    posed(scan(index, points.chain(rings).collect()), pose)
}

/// Transparent cells by their place in the map.
fn glass(out: &ScanOutput) -> Vec<[i64; 2]> {
    let cell = |at_m: f64| (at_m / out.grid.resolution_m).round() as i64;
    let origin = [cell(out.grid.origin_x_m), cell(out.grid.origin_y_m)];
    let all = out.classes.iter().enumerate().filter(|(_, class)| **class == CellClass::Transparent as u8);
    let width = out.grid.width as usize;
    all.map(|(at, _)| [origin[0] + (at % width) as i64, origin[1] + (at / width) as i64]).collect()
}

#[test]
fn truth_glass_neither_moves_nor_blurs_on_a_way_there_and_back() {
    if skipped() {
        return;
    }
    let config = config();
    let first = frame(0, pose(0.0, 0.0, 0.0), true);
    let mut pipeline = open(&config, &first);
    let seen = glass(&step(&mut pipeline, &first));
    assert_eq!(seen.len(), 7, "{seen:?}");
    let mut index = 0;
    let mut drive = |x: f64, yaw: f64| {
        index += 1;
        glass(&step(&mut pipeline, &frame(index, pose(x, 0.0, yaw), false)))
    };
    for tenth in 0..=10 {
        assert_eq!(drive(0.1 * f64::from(tenth), 0.0), seen);
    }
    for turn in 0..50 {
        assert_eq!(drive(1.0, f64::from(turn + 1) * 7.0_f64.to_radians()), seen, "turn {turn}");
    }
    for tenth in (0..=10).rev() {
        assert_eq!(drive(0.1 * f64::from(tenth), 0.0), seen);
    }
}

#[test]
fn truth_a_pane_grows_and_is_forgotten_out_of_the_window_or_by_decay() {
    if skipped() {
        return;
    }
    let first = frame(0, pose(0.0, 0.0, 0.0), true);
    let mut pipeline = open(&config(), &first);
    let seen = glass(&step(&mut pipeline, &first));
    // Seen again from half a metre to the side, the patch lies elsewhere on the pane: both are kept.
    let aside = pose(0.0, 1.0, 0.0);
    let mut moved = frame(1, aside, true);
    for point in moved.scan.points.iter_mut().filter(|point| point.ring == 1 && point.x_m < 50.0) {
        point.y_m += 1.0;
    }
    let joined = glass(&step(&mut pipeline, &moved));
    assert!(joined.len() == 14 && seen.iter().all(|cell| joined.contains(cell)), "{joined:?}");
    let away = glass(&step(&mut pipeline, &frame(2, pose(-20.0, 0.0, 0.0), false)));
    assert!(away.is_empty());
    let back = glass(&step(&mut pipeline, &frame(3, pose(0.0, 0.0, 0.0), false)));
    assert!(back.is_empty(), "it left the window");

    let fading = Config { transparent_decay_s: 0.02, ..config() };
    let mut pipeline = open(&fading, &first);
    assert_eq!(glass(&step(&mut pipeline, &first)).len(), 7);
    let later: Vec<usize> = (1..5)
        .map(|index| glass(&step(&mut pipeline, &frame(index, pose(0.0, 0.0, 0.0), false))).len())
        .collect();
    assert_eq!(later, [7, 0, 0, 0], "960 steps fall by e^-5 a scan");
}

/// Mean of the glass remembered, in the layers' unit, where it was seen first, after `scans` scans that do not see it.
fn left_after(decay_s: f64, scans: u64, period_ns: u64) -> f64 {
    let fading = Config { transparent_decay_s: decay_s, ..config() };
    let first = frame(0, pose(0.0, 0.0, 0.0), true);
    let mut pipeline = open(&fading, &first);
    let mut out = step(&mut pipeline, &first);
    for index in 1..=scans {
        let mut next = frame(index, pose(0.0, 0.0, 0.0), false);
        next.scan.stamp_ns = first.scan.stamp_ns + index * period_ns;
        out = step(&mut pipeline, &next);
    }
    let seen: Vec<f64> =
        grid(&out, "false_negative").iter().filter(|v| **v > 0.0).map(|v| f64::from(*v)).collect();
    assert_eq!(seen.len(), 7);
    seen.iter().sum::<f64>() / 7.0
}

#[test]
fn truth_glass_fades_by_its_decay_whatever_the_rate_of_scans() {
    if skipped() {
        return;
    }
    let whole = left_after(0.0, 0, 1);
    for (decay_s, scans, period_ns) in [
        (60.0, 120, 100_000_000),
        (60.0, 6, 2_000_000_000),
        (60.0, 120, 1_000_000),
        (3600.0, 120, 100_000_000),
    ] {
        let want = whole * (-((scans * period_ns) as f64) * 1e-9 / decay_s).exp();
        let got = left_after(decay_s, scans, period_ns);
        let off = (got / want - 1.0).abs();
        assert!(
            off < 0.002,
            "decay {decay_s} s, {scans} scans each {period_ns} ns: {got} of {whole}, not {want}"
        );
    }
}

#[test]
fn a_larger_scan_changes_nothing_of_what_is_built_or_remembered() {
    if skipped() {
        return;
    }
    let first = frame(0, pose(0.0, 0.0, 0.0), true);
    let mut pipeline = open(&config(), &first);
    pipeline.submit(&first).unwrap();
    let mut large = frame(1, pose(0.0, 0.0, 0.0), false);
    let buffers = |pipeline: &ScanPipeline| pipeline.mapper.context().counters().hal.buffer_memory.read();
    let built = buffers(&pipeline);
    large.scan.points.resize(10 * first.scan.points.len() + 50_000, point([70.0, 0.0, 0.0], 1.0));
    pipeline.submit(&large).unwrap();
    let outputs: Vec<_> = std::iter::from_fn(|| pipeline.receive().unwrap()).collect();
    assert_eq!(buffers(&pipeline), built, "nothing is allocated");
    assert_eq!(outputs.iter().map(|out| out.index).collect::<Vec<_>>(), [0, 1]);
    assert_eq!(glass(&outputs[0]).len(), 7);
    assert_eq!(glass(&outputs[1]), glass(&outputs[0]));
    // One point more than the passes are built for is refused, with the key that says so.
    large.scan.points.resize(262_145, point([70.0, 0.0, 0.0], 1.0));
    let reason = pipeline.submit(&large).unwrap_err().to_string();
    assert!(reason.contains("262145 points") && reason.contains("max_points"), "{reason}");
}
