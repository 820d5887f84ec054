//! Still scenes: occupied, free and unknown cells against geometry in f64.

use crate::support::run::FrameOutput;
use glam::DVec2;
use limpid::Config;
use limpid::sensor::FramePose;

use crate::reference::back_project::back_project;
use crate::reference::see_through::{seen_through, trusted_rays};
use crate::support::camera_job::{small_map, view};
use crate::support::gpu::skipped;
use crate::support::run::{cell, run, still};
use crate::support::scene::{Block, Scene, pose, small_camera};

const UNKNOWN: u8 = 255;
const FREE: u8 = 0;
const OCCUPIED: u8 = 254;

/// Costs without inflation are states: 0, 254, 255.
fn config() -> Config {
    Config { inflation_radius_m: 0.0, inscribed_radius_m: 0.0, mark_range_m: 2.8, ..small_map() }
}

/// What a map should show after ten frames of a still scene, and through which cells a border of view runs: rays cross
/// them, but not their middle.
fn truth(scene: &Scene, pose: FramePose) -> (Vec<u8>, Vec<bool>) {
    let (config, camera, side) = (config(), small_camera(), 120);
    let (window_from_camera, depth_m) = view(scene, &camera, pose, 3.0);
    let gated: Vec<f32> = depth_m.iter().map(|&d| if (0.17..=5.0).contains(&d) { d } else { 0.0 }).collect();
    let weights = vec![1.0; gated.len()];
    let hits = back_project(&config, side, &camera, window_from_camera, &gated, &weights);
    let rays = trusted_rays(&config, &camera, window_from_camera, &gated, &weights);
    let state = |i: usize| {
        let corner = DVec2::new((i % side) as f64, (i / side) as f64) * config.resolution_m;
        match hits[i] {
            h if h.count > 0 => OCCUPIED,
            h if h.floor || seen_through(&config, &rays, corner, None) => FREE,
            _ => UNKNOWN,
        }
    };
    let states: Vec<u8> = (0..side * side).map(state).collect();
    let core = Config { resolution_m: 0.5 * config.resolution_m, ..config.clone() };
    let split = |i: usize| {
        let corner = DVec2::new((i % side) as f64 + 0.25, (i / side) as f64 + 0.25) * config.resolution_m;
        states[i] == FREE && !hits[i].floor && !seen_through(&core, &rays, corner, None)
    };
    let splits = (0..side * side).map(split).collect();
    (states, splits)
}

fn at_border(states: &[u8], i: usize) -> bool {
    let (x, y) = (i % 120, i / 120);
    let rows = y.saturating_sub(1)..=(y + 1).min(119);
    rows.flat_map(|row| (x.saturating_sub(1)..=(x + 1).min(119)).map(move |c| row * 120 + c))
        .any(|near| states[near] != states[i])
}

/// Asserts that no cell away from borders differs from the truth, and gives the map.
#[track_caller]
fn check(name: &str, scene: &Scene, pose: FramePose) -> FrameOutput {
    let out = run(&config(), &still(scene, pose, 10)).pop().unwrap();
    let (want, split) = truth(scene, pose);
    let differing: Vec<usize> = (0..want.len()).filter(|&i| out.costmap[i] != want[i]).collect();
    let inner: Vec<usize> =
        differing.iter().copied().filter(|&i| !at_border(&want, i) && !split[i]).collect();
    let tally = |state: u8| want.iter().filter(|s| **s == state).count();
    let invented = differing.iter().filter(|&&i| want[i] == UNKNOWN).count();
    println!(
        "{name}: {} differ, {} away from borders; truth: {} occupied, {} free",
        differing.len(),
        inner.len(),
        tally(OCCUPIED),
        tally(FREE)
    );
    assert!(tally(FREE) > 400 && tally(OCCUPIED) > 5, "{name}");
    let lost: Vec<_> =
        differing.iter().filter(|&&i| want[i] == OCCUPIED || out.costmap[i] == OCCUPIED).collect();
    assert!(lost.is_empty(), "{name}: occupied cells are those with hits, at borders too; not {lost:?}");
    assert_eq!(invented, 0, "{name}: nothing is free that no ray crosses, at borders too");
    assert!(inner.is_empty(), "{name}: {inner:?} (cells of 120 a row)");
    assert!(differing.len() * 10 < tally(FREE), "{name}: {} at borders", differing.len());
    out
}

fn at(out: &FrameOutput, x: f64, y: f64) -> u8 {
    out.costmap[cell(out, x, y)]
}

fn ahead() -> FramePose {
    pose(0.012, 0.023, 0.0, 0.6, 0.25)
}

#[test]
fn a_wall_is_occupied_before_it_free_and_behind_it_unknown() {
    if skipped() {
        return;
    }
    let wall = Scene::of(&[Block::new([2.013, -3.0, 0.0], [2.2, 3.0, 2.5])]);
    let out = check("wall", &wall, ahead());
    assert_eq!([1.5, 2.02, 2.3].map(|x| at(&out, x, 0.02)), [FREE, OCCUPIED, UNKNOWN]);
    check("wall, aslant", &wall, pose(0.012, 0.023, 0.5, 0.6, 0.25));
}

#[test]
fn a_low_box_stays_though_rays_pass_over_it() {
    if skipped() {
        return;
    }
    let scene = Scene::of(&[
        Block::new([1.013, -0.3, 0.0], [1.32, 0.3, 0.21]),
        Block::new([2.413, -3.0, 0.0], [2.6, 3.0, 2.5]),
    ]);
    let out = check("low box", &scene, ahead());
    assert_eq!(
        [0.8, 1.02, 1.15, 2.0, 2.42].map(|x| at(&out, x, 0.02)),
        [FREE, OCCUPIED, OCCUPIED, FREE, OCCUPIED]
    );
}

#[test]
fn a_table_is_occupied_where_seen_from_above_and_its_legs_where_seen_from_below() {
    if skipped() {
        return;
    }
    let leg = |x: f64, y: f64| Block::new([x, y, 0.0], [x + 0.056, y + 0.056, 0.7]);
    let table = Scene::of(&[
        Block::new([1.013, -0.41, 0.7], [1.81, 0.43, 0.74]),
        leg(1.013, -0.41),
        leg(1.013, 0.37),
        leg(1.743, -0.41),
        leg(1.743, 0.37),
    ]);
    let above = check("table from above", &table, pose(0.012, 0.023, 0.0, 1.3, 0.5));
    assert_eq!(at(&above, 1.4, 0.02), OCCUPIED);
    let level = check("table from below", &table, pose(0.012, 0.023, 0.0, 0.4, 0.0));
    assert_eq!([at(&level, 1.4, 0.02), at(&level, 1.02, 0.39)], [OCCUPIED; 2], "its underside and a leg");
    let down = check("under the table", &table, pose(0.012, 0.023, 0.0, 0.4, 0.5));
    assert_eq!([at(&down, 1.4, 0.02), at(&down, 1.02, 0.39)], [FREE, OCCUPIED], "only the floor and a leg");
}

#[test]
fn an_overhang_above_the_band_is_no_obstacle() {
    if skipped() {
        return;
    }
    let scene = Scene::of(&[
        Block::new([1.013, -1.0, 2.05], [1.6, 1.0, 2.3]),
        Block::new([2.413, -3.0, 0.0], [2.6, 3.0, 2.5]),
    ]);
    for pitch in [0.1, -0.5] {
        let out = check("overhang", &scene, pose(0.012, 0.023, 0.0, 1.2, pitch));
        assert_eq!(at(&out, 1.2, 0.02), FREE, "pitch {pitch}");
    }
    let low = Scene::of(&[
        Block::new([1.013, -1.0, 1.8], [1.6, 1.0, 2.3]),
        Block::new([2.413, -3.0, 0.0], [2.6, 3.0, 2.5]),
    ]);
    let out = check("low overhang", &low, pose(0.012, 0.023, 0.0, 1.2, -0.5));
    assert_eq!(at(&out, 1.02, 0.02), OCCUPIED);
}
