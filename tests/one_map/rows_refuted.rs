//! Row 5 of the rule: what a camera doubts is refuted by beams that went through it.

use limpid::Config;
use limpid::config::{Fusion, LidarClearsCamera};

use super::rig::{
    FRAME_MS, FRAMES, Published, Return, Rig, camera, camera_and_lidar, confident, config, frame, mount,
    room, sweep,
};
use crate::support::gpu::skipped;
use crate::support::scene::{Block, Scene, small_camera};

const CAMERA: usize = 0;
const LIDAR: usize = 1;
const PHANTOM: [f64; 2] = [1.52, 0.02];
const WALL_X_M: f64 = 3.0;

/// What the camera sees where nothing is: hits between 0.4 and 0.8 m above the ground.
fn scene() -> Scene {
    room(&[Block::new([1.513, -0.2, 0.4], [1.6, 0.2, 0.8])])
}

/// Beams through the phantom at heights from `low_m` to `high_m`, `step_m` apart, to a wall behind.
fn beams(low_m: f64, high_m: f64, step_m: f64) -> Vec<Return> {
    let rows = ((high_m - low_m) / step_m).round() as u32 + 1;
    let row = |row: u32| {
        // A beam at height h over the middle of the cell at 1.525 m lies this high at the wall.
        let z_m = 0.6 + (low_m + f64::from(row) * step_m - 0.6) * (WALL_X_M - 0.012) / (1.525 - 0.012);
        (-40..=40).map(move |step| ([WALL_X_M, 0.01 * f64::from(step), z_m], 40.0))
    };
    (0..rows).flat_map(row).collect()
}

/// The map after ten frames of a `confidence` and a scan `after_ms` after the last of them.
fn refuted(config: &Config, confidence: f32, returns: &[Return], after_ms: i64) -> Published {
    let sensors = [camera("front", config, small_camera(), true), camera_and_lidar(config)[LIDAR].clone()];
    let mut rig = Rig::open(config, &sensors);
    let first_ms = 200;
    let last_ms = first_ms + (FRAMES - 1) * FRAME_MS;
    let scan = sweep(LIDAR, last_ms.checked_add_signed(after_ms).unwrap(), returns);
    if after_ms < 0 {
        rig.see(&scan);
    }
    for index in 0..FRAMES {
        let frame = frame(CAMERA, first_ms + index * FRAME_MS, &scene(), small_camera(), mount(0.0, 0.0));
        rig.see(&confident(frame, confidence));
    }
    if after_ms >= 0 {
        rig.see(&scan);
    }
    rig.publish(None)
}

/// R of 0.5 counts fully, so that the camera marks, and is below 0.6, so that it doubts.
fn gated(lidar_clears_camera: LidarClearsCamera) -> Config {
    Config { fusion: Fusion::Gate, lidar_clears_camera, ..config() }
}

#[test]
fn truth_row_5_follows_lidar_clears_camera_and_the_camera_s_doubt() {
    if skipped() {
        return;
    }
    let through = beams(0.35, 0.85, 0.05);
    for (clears, confidence, row, sensor) in [
        (LidarClearsCamera::Doubtful, 0.5, 5, LIDAR),
        (LidarClearsCamera::Doubtful, 0.9, 6, CAMERA),
        (LidarClearsCamera::Never, 0.5, 6, CAMERA),
        (LidarClearsCamera::Always, 0.5, 5, LIDAR),
        (LidarClearsCamera::Always, 0.9, 5, LIDAR),
    ] {
        let out = refuted(&gated(clears), confidence, &through, 100);
        let cost = if row == 5 { 0 } else { 254 };
        assert_eq!(out.said(PHANTOM), (row, cost), "{clears:?} at R = {confidence}");
        assert_eq!(out.verdict(PHANTOM).sensor(), Some(sensor), "{clears:?} at R = {confidence}");
        let age_s = if row == 5 { 0.0 } else { 0.1 };
        assert!((out.verdict(PHANTOM).age_s() - age_s).abs() < 1e-9, "{}", out.verdict(PHANTOM).age_s());
    }
}

#[test]
fn truth_row_5_needs_newer_beams_at_the_heights_of_the_hits_and_between() {
    if skipped() {
        return;
    }
    let config = gated(LidarClearsCamera::Always);
    let at = |returns: &[Return], after_ms: i64| refuted(&config, 0.5, returns, after_ms).said(PHANTOM);
    assert_eq!(at(&beams(0.35, 0.85, 0.05), 100), (5, 0), "the control");
    assert_eq!(at(&beams(0.35, 0.85, 0.05), 0), (6, 254), "as old as the hits");
    assert_eq!(at(&beams(0.35, 0.85, 0.05), -330), (6, 254), "older than the hits");
    assert_eq!(at(&beams(0.35, 0.85, 0.25), 100), (6, 254), "a board fits between two beams");
    // Beams at both ends of the hits, which lie between 0.40 and 0.80 m: what is between them decides.
    assert_eq!(at(&beams(0.405, 0.795, 0.13), 100), (6, 254), "0.13 m apart");
    assert_eq!(at(&beams(0.405, 0.795, 0.078), 100), (5, 0), "0.08 m apart");
    assert_eq!(at(&beams(0.50, 0.85, 0.05), 100), (6, 254), "no beam as low as the lowest hit");
    assert_eq!(at(&beams(0.35, 0.70, 0.05), 100), (6, 254), "no beam as high as the highest hit");
    let mut ends = beams(0.35, 0.85, 0.05);
    ends.push(([1.52, 0.02, 0.7], 40.0));
    assert_eq!(at(&ends, 100), (4, 254), "one beam ends there");
}

#[test]
fn truth_beams_over_a_low_box_say_nothing_of_it() {
    if skipped() {
        return;
    }
    let config = gated(LidarClearsCamera::Always);
    let mut rig = Rig::open(&config, &camera_and_lidar(&config));
    let low = room(&[Block::new([1.513, -0.2, 0.0], [1.6, 0.2, 0.3])]);
    for index in 0..FRAMES {
        rig.see(&frame(CAMERA, index * FRAME_MS, &low, small_camera(), mount(0.0, 0.2)));
    }
    rig.see(&sweep(LIDAR, 400, &beams(0.4, 0.8, 0.05)));
    let out = rig.publish(None);
    assert_eq!(out.said(PHANTOM), (6, 254));
    assert_eq!(
        (out.said([1.22, 0.02]), out.verdict([1.22, 0.02]).sensor()),
        ((8, 0), Some(LIDAR)),
        "before it"
    );
    rig.see(&sweep(LIDAR, 410, &beams(0.1, 0.8, 0.05)));
    assert_eq!(rig.publish(None).said(PHANTOM), (5, 0), "the control: beams at its own heights too");
}

#[test]
fn truth_row_5_ends_with_the_camera_s_next_hit() {
    if skipped() {
        return;
    }
    let config = gated(LidarClearsCamera::Doubtful);
    let sensors = [camera("front", &config, small_camera(), true), camera_and_lidar(&config)[LIDAR].clone()];
    let mut rig = Rig::open(&config, &sensors);
    let look = |rig: &mut Rig, ms: u64| {
        rig.see(&confident(frame(CAMERA, ms, &scene(), small_camera(), mount(0.0, 0.0)), 0.5));
        rig.publish(None).said(PHANTOM)
    };
    for index in 0..FRAMES {
        look(&mut rig, index * FRAME_MS);
    }
    for round in 0..3 {
        rig.see(&sweep(LIDAR, 310 + 100 * round, &beams(0.35, 0.85, 0.05)));
        assert_eq!(rig.publish(None).said(PHANTOM), (5, 0), "after a scan");
        assert_eq!(look(&mut rig, 340 + 100 * round), (6, 254), "after a frame: its hits are newer");
    }
}

#[test]
fn truth_weighted_hits_are_doubtful_only_where_surer_ones_marked_the_cell() {
    if skipped() {
        return;
    }
    let config = config();
    assert_eq!((config.fusion, config.lidar_clears_camera), (Fusion::Auto, LidarClearsCamera::Doubtful));
    let sensors = [camera("front", &config, small_camera(), true), camera_and_lidar(&config)[LIDAR].clone()];
    for (weak_frames, said) in [(0, (6, 254)), (3, (5, 0))] {
        let mut rig = Rig::open(&config, &sensors);
        for index in 0..FRAMES + weak_frames {
            let confidence = if index < FRAMES { 1.0 } else { 0.55 };
            let frame = frame(CAMERA, index * FRAME_MS, &scene(), small_camera(), mount(0.0, 0.0));
            rig.see(&confident(frame, confidence));
        }
        rig.see(&sweep(LIDAR, 500, &beams(0.35, 0.85, 0.05)));
        assert_eq!(rig.publish(None).said(PHANTOM), said, "{weak_frames} weak frames");
    }
    // Weak from the first, the cell never gets to the threshold of 0.7.
    let out = refuted(&config, 0.55, &beams(0.35, 0.85, 0.05), 100);
    assert_eq!(out.said(PHANTOM), (8, 0));
}
