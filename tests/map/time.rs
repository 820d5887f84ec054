//! How many frames it takes: hysteresis, confirmations, forgetting, by the formula.

use limpid::Config;
use limpid::config::Fusion;
use limpid::sensor::RgbdFrame;

use crate::support::gpu::skipped;
use crate::support::run::{evidence, lethal, occupancy, run, still};
use crate::support::scene::{Block, Scene, pose};

/// In front of the camera at (0, 0), its face inside a cell.
fn wall() -> Scene {
    Scene::of(&[Block::new([1.52, -1.0, 0.0], [1.7, 1.0, 1.5])])
}

fn far_wall() -> Scene {
    Scene::of(&[Block::new([3.52, -4.0, 0.0], [3.7, 4.0, 1.5])])
}

/// The face of [`wall`].
const FACE: [f64; 2] = [1.53, 0.02];

fn ahead() -> limpid::sensor::FramePose {
    pose(0.01, 0.02, 0.0, 0.6, 0.2)
}

/// `seen` frames of the wall, then `gone` frames without it.
fn wall_that_goes(seen: u64, gone: u64) -> Vec<RgbdFrame> {
    let mut frames = still(&wall(), ahead(), seen);
    frames.extend(still(&far_wall(), ahead(), seen + gone).into_iter().skip(seen as usize));
    frames
}

fn first_lethal(config: &Config, frames: &[RgbdFrame]) -> Option<usize> {
    run(config, frames).iter().position(|out| lethal(out, FACE[0], FACE[1]))
}

/// Frames of e = 1 until p >= 0.7.
fn frames_to_occupied(lambda: f64) -> usize {
    (1..).find(|&n| 1.0 - lambda.powi(n) >= 0.7).unwrap() as usize
}

#[test]
fn occupied_after_as_many_frames_as_the_formula_says() {
    if skipped() {
        return;
    }
    assert_eq!(frames_to_occupied(0.85), 8);
    for lambda in [0.85, 0.5, 0.0] {
        let config = Config { lambda, ..Config::default() };
        let count = frames_to_occupied(lambda);
        assert_eq!(first_lethal(&config, &still(&wall(), ahead(), 10)), Some(count - 1), "lambda {lambda}");
    }
}

#[test]
fn a_new_obstacle_is_never_published_as_free() {
    if skipped() {
        return;
    }
    for out in run(&Config::default(), &still(&wall(), ahead(), 7)) {
        let i = crate::support::run::cell(&out, FACE[0], FACE[1]);
        assert_eq!(out.costmap[i], 255, "frame {}", out.index);
    }
}

#[test]
fn an_obstacle_that_goes_away_is_forgotten_after_the_formula_s_frames() {
    if skipped() {
        return;
    }
    let seen = 12;
    let p_then = 1.0 - 0.85_f64.powi(seen);
    let gone = (1..).find(|&n| p_then * 0.85_f64.powi(n) < 0.5).unwrap();
    let out = run(&Config::default(), &wall_that_goes(seen as u64, gone as u64 + 2));
    let states: Vec<bool> = out.iter().map(|out| lethal(out, FACE[0], FACE[1])).collect();
    let want = |i: usize| (7..(seen + gone - 1) as usize).contains(&i);
    assert_eq!(states, (0..out.len()).map(want).collect::<Vec<_>>());
    let last = out.last().unwrap();
    let i = crate::support::run::cell(last, FACE[0], FACE[1]);
    assert_eq!(last.costmap[i], 0, "free, and nothing near is left");
}

#[test]
fn confirmations_delay_the_first_mark() {
    if skipped() {
        return;
    }
    let config = Config { confirmations: 11, ..Config::default() };
    assert_eq!(first_lethal(&config, &still(&wall(), ahead(), 13)), Some(10));
    let quick = Config { confirmations: 3, lambda: 0.0, ..Config::default() };
    assert_eq!(first_lethal(&quick, &still(&wall(), ahead(), 4)), Some(2));
}

#[test]
fn reliability_of_0_6_never_marks_and_of_0_8_does() {
    if skipped() {
        return;
    }
    for (weight, first) in [(0.6_f32, None), (0.8, (1..).position(|n| 0.8 * (1.0 - 0.85_f64.powi(n)) >= 0.7))]
    {
        let mut frames = still(&wall(), ahead(), 24);
        for frame in &mut frames {
            frame.confidence = Some(vec![weight; frame.depth.samples.len()]);
        }
        let out = run(&Config { fusion: Fusion::Weight, ..Config::default() }, &frames);
        assert_eq!(out.iter().position(|out| lethal(out, FACE[0], FACE[1])), first, "R = {weight}");
        let p = occupancy(out.last().unwrap(), FACE[0], FACE[1]);
        let want = f64::from(weight) * (1.0 - 0.85_f64.powi(24));
        assert!((f64::from(p) - want).abs() < 2e-4, "{p} where {want} is wanted");
    }
}

#[test]
fn gated_reliability_counts_fully_above_tau_and_not_at_all_up_to_it() {
    if skipped() {
        return;
    }
    let fully = (1..).position(|n| 1.0 - 0.85_f64.powi(n) >= 0.7);
    for (weight, first) in [(0.3_f32, None), (0.31, fully), (0.6, fully), (1.0, fully)] {
        let mut frames = still(&wall(), ahead(), 10);
        for frame in &mut frames {
            frame.confidence = Some(vec![weight; frame.depth.samples.len()]);
        }
        let out = run(&Config { fusion: Fusion::Gate, ..Config::default() }, &frames);
        assert_eq!(out.iter().position(|out| lethal(out, FACE[0], FACE[1])), first, "R = {weight}");
        let p = f64::from(occupancy(out.last().unwrap(), FACE[0], FACE[1]));
        let want = if first.is_some() { 1.0 - 0.85_f64.powi(10) } else { 0.0 };
        assert!((p - want).abs() < 1e-5, "{p} where {want} is wanted");
    }
}

#[test]
fn untrusted_frames_neither_mark_nor_clear() {
    if skipped() {
        return;
    }
    let mut frames = wall_that_goes(10, 12);
    for frame in &mut frames {
        let weight = if frame.index < 10 { 1.0 } else { 0.3 };
        frame.confidence = Some(vec![weight; frame.depth.samples.len()]);
    }
    frames[21].confidence = None;
    let out = run(&Config::default(), &frames);
    let p = occupancy(&out[9], FACE[0], FACE[1]);
    for out in &out[10..] {
        assert_eq!(evidence(out, FACE[0], FACE[1]), -1.0, "frame {}", out.index);
        assert_eq!(occupancy(out, FACE[0], FACE[1]), p);
        assert!(lethal(out, FACE[0], FACE[1]) && out.degraded);
    }
}

#[test]
fn rate_independent_lambda_forgets_by_time() {
    if skipped() {
        return;
    }
    let config = Config { rate_independent: true, ..Config::default() };
    let mut frames = still(&wall(), ahead(), 4);
    for (i, frame) in (0..).zip(&mut frames) {
        frame.depth.stamp_ns = 1_700_000_000_000_000_000 + i * 100_000_000;
    }
    let out = run(&config, &frames);
    // The first frame has no time before it; each of the others is worth three at 30 Hz.
    for (i, out) in out.iter().enumerate() {
        let want = 1.0 - 0.85_f64.powi(1 + 3 * i as i32);
        let p = f64::from(occupancy(out, FACE[0], FACE[1]));
        assert!((p - want).abs() < 1e-5, "frame {i}: {p} where {want} is wanted");
    }
    let by_frame = run(&Config::default(), &frames);
    assert!((occupancy(&by_frame[3], FACE[0], FACE[1]) - (1.0 - 0.85_f32.powi(4))).abs() < 1e-5);
}

#[test]
fn rays_over_a_low_box_keep_it_to_the_bit() {
    if skipped() {
        return;
    }
    let scene = Scene::of(&[
        Block::new([0.813, -0.2, 0.0], [0.99, 0.2, 0.21]),
        Block::new([3.52, -4.0, 0.0], [3.7, 4.0, 2.5]),
    ]);
    let mut frames = still(&scene, pose(0.01, 0.02, 0.0, 0.6, 0.4), 10);
    // Level, the lowest ray passes the box's face at 0.6 m - 0.8 m * 59.5 / 146 = 0.27 m.
    frames.extend(still(&scene, pose(0.01, 0.02, 0.0, 0.6, 0.0), 30).into_iter().skip(10));
    let out = run(&Config::default(), &frames);
    assert!(lethal(&out[9], 0.82, 0.02));
    for level in &out[10..] {
        assert_eq!(evidence(level, 0.82, 0.02), -1.0, "frame {}", level.index);
        assert_eq!(evidence(level, 0.82, 0.32), 0.0, "beside the box the same rays clear");
        assert_eq!(occupancy(level, 0.82, 0.02), occupancy(&out[9], 0.82, 0.02));
        assert!(lethal(level, 0.82, 0.02));
    }
}
