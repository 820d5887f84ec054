//! Where the ground drops away, through the whole pipeline, on analytic scenes whose truth is known.

use glam::{DQuat, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::config::Method;
use limpid::map::rule::RuleSettings;
use limpid::mapper::{Mapper, Options, SensorInfo};
use limpid::sensor::{CameraModel, DepthSamples, FramePose, Observation, RgbdFrame, SensorData, SensorPose};
use limpid::sim::Simulator;

use super::ground::{DROP, camera_at, camera_mapper, config, drops, frames, platform, row_at, scan, updates};
use crate::support::gpu::skipped;
use crate::support::run::submit;
use crate::support::scene::{Block, Scene, frame, small_camera};

#[test]
fn the_edge_of_a_platform_is_closed_and_the_platform_is_free() {
    if skipped() {
        return;
    }
    for depth_m in [0.2, 0.6, 1.1] {
        let scene = Scene::of(&platform(1.2, depth_m));
        let at = camera_at(0.0, depth_m, 0.35);
        let config = Config { ground_z_m: depth_m, ..config() };
        let updates = updates(&config, &frames(&scene, at, at, 14));
        let last = updates.last().unwrap();
        assert!(drops(&updates[2]).is_empty(), "two or three frames are too few");
        let found = drops(last);
        // Every straight way over the edge within the view meets a drop within two cells of it.
        for k in -8..=8 {
            let y = 0.04 * f64::from(k);
            let closed = (0..=10).any(|step| row_at(last, 1.15 + 0.02 * f64::from(step), y) == DROP);
            assert!(closed, "{depth_m} m deep, at y = {y}: {found:?}");
        }
        assert!(
            found.iter().all(|[x, _]| *x > 1.2 - 0.051),
            "{depth_m} m deep: the platform is whole: {found:?}"
        );
        assert_eq!(row_at(last, 0.9, 0.0), 9, "the platform is free");
    }
}

#[test]
fn stairs_down_are_drops() {
    if skipped() {
        return;
    }
    // Steps of 0.18 m by 0.28 m from x = 1.5 on, seen from a floor at z = 0.9.
    let mut blocks = platform(1.5, 0.9);
    blocks.extend((1..5).map(|k| {
        let k = f64::from(k);
        Block::new([1.5, -1.0, -1.0], [1.5 + 0.28 * k, 1.0, 0.9 - 0.18 * k])
    }));
    let at = camera_at(0.0, 0.9, 0.45);
    let config = Config { ground_z_m: 0.9, ..config() };
    let updates = updates(&config, &frames(&Scene::of(&blocks), at, at, 14));
    let last = updates.last().unwrap();
    let found = drops(last);
    for k in -8..=8 {
        let y = 0.05 * f64::from(k);
        let closed = (0..=15).any(|step| row_at(last, 1.5 + 0.02 * f64::from(step), y) == DROP);
        assert!(closed, "at y = {y}: {found:?}");
    }
    assert!(found.iter().all(|[x, _]| *x > 1.45), "{found:?}");
}

#[test]
fn a_trench_is_closed_where_its_bottom_is_seen_and_no_farther() {
    if skipped() {
        return;
    }
    let mut blocks = platform(1.2, 0.3);
    blocks.push(Block::new([1.8, -9.0, -1.0], [9.0, 9.0, 0.3]));
    let at = camera_at(0.0, 0.3, 0.35);
    let config = Config { ground_z_m: 0.3, ..config() };
    let updates = updates(&config, &frames(&Scene::of(&blocks), at, at, 14));
    let last = updates.last().unwrap();
    let found = drops(last);
    for k in -8..=8 {
        let y = 0.04 * f64::from(k);
        let closed = (0..=10).any(|step| row_at(last, 1.15 + 0.02 * f64::from(step), y) == DROP);
        assert!(closed, "at y = {y}: {found:?}");
    }
    assert!(found.iter().all(|[x, _]| (1.149..1.851).contains(x)), "{found:?}");
    assert_eq!(row_at(last, 2.2, 0.0), 9, "the floor behind it is free");
}

/// The simulated drive up to an edge at x = 1.2, with the base on the platform, 0.6 m above the map's z = 0.
fn drive() -> Vec<RgbdFrame> {
    let scene = limpid::sim::scene::Scene::read("testdata/edge.yaml".as_ref()).unwrap();
    let camera = scene.camera.model();
    let mut simulator = Simulator::open(&scene, None, false).unwrap();
    let poses = simulator.poses();
    let up = DVec3::Z * 0.6;
    let frame_at = |(index, pose): (u64, &FramePose)| {
        let seen = simulator.frame(index, *pose).unwrap();
        let mut pose = *pose;
        pose.map_from_base.translation_m += up;
        pose.base_from_camera.translation_m -= up;
        frame(index, camera, Some(pose), DepthSamples::Integer { raw: seen.depth_mm, unit_m: 0.001 })
    };
    (0..).zip(&poses).map(frame_at).collect()
}

#[test]
fn a_simulated_edge_is_closed_before_the_robot_is_there() {
    if skipped() {
        return;
    }
    let frames = drive();
    let config = Config { ground_z_m: 0.6, method: Method::Naive, ..config() };
    let updates = updates(&config, &frames);
    for update in &updates {
        let found = drops(update);
        assert!(found.iter().all(|[x, _]| *x > 1.2 - 0.051), "the platform is whole: {found:?}");
    }
    let last = updates.last().unwrap();
    assert!(last.map_from_base.translation_m.x < 0.65, "{:?}", last.map_from_base);
    for k in -8..=8 {
        let y = 0.05 * f64::from(k);
        let closed = (0..=25).any(|step| row_at(last, 1.15 + 0.02 * f64::from(step), y) == DROP);
        assert!(closed, "at y = {y}: {:?}", drops(last));
    }
}

#[test]
fn a_ramp_down_is_no_drop() {
    if skipped() {
        return;
    }
    // Steps too low to tell from a ramp of 8 degrees, from x = 1.2 to a floor 0.42 m lower.
    let mut blocks = platform(1.2, 1.0);
    blocks.extend((1..=60).map(|k| {
        let k = f64::from(k);
        Block::new([1.2, -9.0, -1.0], [1.2 + 0.05 * k, 9.0, 1.0 - 0.007 * k])
    }));
    blocks.push(Block::new([1.2, -9.0, -1.0], [9.0, 9.0, 0.58]));
    let at = camera_at(0.0, 1.0, 0.25);
    let config = Config { ground_z_m: 1.0, ..config() };
    for update in updates(&config, &frames(&Scene::of(&blocks), at, at, 14)) {
        assert_eq!(drops(&update), [[0.0; 2]; 0]);
    }
}

#[test]
fn a_near_floor_that_is_measured_too_far_is_no_drop() {
    if skipped() {
        return;
    }
    let at = camera_at(0.0, 0.0, 0.3);
    let camera = small_camera();
    let plain = Scene::of(&[Block::new([3.0, -9.0, 0.0], [3.2, 9.0, 2.5])])
        .depth(&camera, at.map_from_base.then(at.base_from_camera));
    // As a stereo matcher has it where disparities are larger than those it searches.
    let far: Vec<f32> = plain
        .iter()
        .enumerate()
        .map(|(at, depth)| if at / camera.width as usize >= 85 { depth * 1.8 } else { *depth })
        .collect();
    let samples = limpid::sensor::DepthSamples::Metres(far);
    let frames: Vec<_> = (0..14).map(|index| frame(index, camera, Some(at), samples.clone())).collect();
    for update in updates(&config(), &frames) {
        assert_eq!(drops(&update), [[0.0; 2]; 0]);
        assert!(update.ground.unwrap().seen);
    }
}

#[test]
fn why_tells_of_a_drop_how_deep_it_is() {
    if skipped() {
        return;
    }
    let at = camera_at(0.0, 0.6, 0.35);
    let config = Config { ground_z_m: 0.6, ..config() };
    let frames = frames(&Scene::of(&platform(1.2, 0.6)), at, at, 14);
    let mut mapper = camera_mapper(&config, &frames[0]);
    let mut last = None;
    for frame in frames {
        submit(&mut mapper, &Observation::of_frame(0, "map", frame)).unwrap();
        last = mapper.wait().unwrap();
    }
    let last = last.unwrap();
    let text = |x: f64| {
        let why = mapper.why(&last, x, 0.0).unwrap().unwrap();
        why.text(&RuleSettings::of(&config), &["front".into()])
    };
    let said = text(1.27);
    assert!(said.starts_with("254: drop, seen by front") && said.contains("(row 12 of the rule)"), "{said}");
    assert!(said.contains("\n  drops: 0.60 m below the ground, seen by front 0.0 s ago"), "{said}");
    assert!(!text(0.9).contains("drops:"), "{}", text(0.9));
}

#[test]
fn what_a_glossy_floor_mirrors_is_no_drop() {
    if skipped() {
        return;
    }
    let wall = Block::new([3.0, -9.0, 0.0], [3.2, 9.0, 2.5]);
    let mirrored = Block::new([3.0, -9.0, -2.5], [3.2, 9.0, 0.0]);
    let at = camera_at(0.0, 0.0, 0.3);
    let camera = small_camera();
    let map_from_camera = at.map_from_base.then(at.base_from_camera);
    let plain = Scene::of(&[wall]).depth(&camera, map_from_camera);
    // In a patch of the image the floor shows the wall's mirror image: straight on, as if there were no floor.
    let through = depth_without_floor(&[mirrored], &camera, map_from_camera);
    let patched: Vec<f32> = (0..plain.len())
        .map(|at| {
            let (u, v) = (at % camera.width as usize, at / camera.width as usize);
            let shows = (60..110).contains(&u) && (70..100).contains(&v) && (u / 4 + v / 3) % 3 != 0;
            if shows && through[at] > 0.0 { through[at] } else { plain[at] }
        })
        .collect();
    let shown = patched.iter().zip(&plain).filter(|(a, b)| a != b).count();
    assert!(shown > 500, "{shown} pixels of a mirror image");
    let samples = limpid::sensor::DepthSamples::Metres(patched);
    let frames: Vec<_> = (0..14).map(|index| frame(index, camera, Some(at), samples.clone())).collect();
    let updates = updates(&config(), &frames);
    for update in &updates {
        assert_eq!(drops(update), [[0.0; 2]; 0]);
        assert!(update.ground.unwrap().seen);
    }
}

/// Depth of blocks where there is no floor; 0 where none is met.
fn depth_without_floor(blocks: &[Block], camera: &CameraModel, map_from_camera: Rigid) -> Vec<f32> {
    // The scene's own floor is at z = 0: everything is lifted so that it lies far below.
    let up = DVec3::Z * 100.0;
    let lifted: Vec<Block> =
        blocks.iter().map(|block| Block { min: block.min + up, max: block.max + up }).collect();
    let from = Rigid { translation_m: map_from_camera.translation_m + up, ..map_from_camera };
    let depth = Scene::of(&lifted).depth(camera, from);
    depth.into_iter().map(|depth| if depth < 50.0 { depth } else { 0.0 }).collect()
}

#[test]
fn a_lidar_sees_the_edge_of_its_floor() {
    if skipped() {
        return;
    }
    let found = |edge: f64| {
        let config = Config { scan_map_size_m: 16.0, ..Config::default() };
        let of = |index: u64| scan(index, DQuat::IDENTITY, edge);
        let options = Options { verdicts: true, ..Options::default() };
        let mut mapper = Mapper::open(&config, &[SensorInfo::lidar(&config, of(0))], &options).unwrap();
        let mut last = None;
        for index in 0..6 {
            let (pose, data) = (Some(SensorPose::SENSOR), SensorData::Scan(of(index)));
            let seen = Observation { sensor: 0, pose, map_frame: "top".into(), goal_m: None, data };
            submit(&mut mapper, &seen).unwrap();
            last = mapper.wait().unwrap();
        }
        let last = last.unwrap();
        assert!(last.ground.unwrap().seen);
        drops(&last)
    };
    assert_eq!(found(f64::INFINITY), [[0.0; 2]; 0], "a floor without an edge");
    let drops = found(3.0);
    assert!(drops.iter().all(|[x, _]| *x > 2.94), "{drops:?}");
    for k in -10..=10 {
        let y = 0.1 * f64::from(k);
        let closed = drops.iter().any(|[at_x, at_y]| (at_y - y).abs() < 0.11 && *at_x < 3.5);
        assert!(closed, "at y = {y}: {drops:?}");
    }
}
