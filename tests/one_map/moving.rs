//! A robot that drives: what its sensors saw stays where it is in the map, however late it comes.

use glam::{DQuat, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::mapper::SensorInfo;
use limpid::sensor::{DepthSamples, Observation, SensorPose};

use super::rig::{
    BASE_M, FRAME_MS, FRAMES, Return, Rig, camera_and_lidar, config, dim_wall, mount, of_samples, room, sweep,
};
use crate::support::gpu::skipped;
use crate::support::scene::{Block, Scene, small_camera};

const CAMERA: usize = 0;
const LIDAR: usize = 1;
const POST: [f64; 2] = [1.52, 0.02];
const WALL: [f64; 2] = [-1.52, 0.02];

/// A frame from the robot `x_m` ahead of where it began.
fn frame(ms: u64, scene: &Scene, x_m: f64) -> Observation {
    let pose = at(x_m, mount(0.0, 0.2));
    let samples = DepthSamples::Metres(scene.depth(&small_camera(), pose.map_from_sensor()));
    Observation { pose: Some(pose), ..of_samples(CAMERA, ms, samples, small_camera(), mount(0.0, 0.2)) }
}

fn at(x_m: f64, base_from_sensor: Rigid) -> SensorPose {
    let map_from_base = Rigid { rotation: DQuat::IDENTITY, translation_m: BASE_M + DVec3::X * x_m };
    SensorPose { map_from_base, base_from_sensor, sweep: None }
}

/// A scan from there: `returns` are places in the map.
fn scan(ms: u64, returns: &[Return], x_m: f64) -> Observation {
    let local: Vec<Return> = returns.iter().map(|&([x, y, z], i)| ([x - x_m, y, z], i)).collect();
    let still = sweep(LIDAR, ms, &local);
    let base_from_sensor = still.pose.unwrap().base_from_sensor;
    Observation { pose: Some(at(x_m, base_from_sensor)), ..still }
}

#[test]
fn truth_what_two_sensors_saw_stays_in_place_while_each_moves_the_window() {
    if skipped() {
        return;
    }
    let config = config();
    let mut rig = Rig::open(&config, &camera_and_lidar(&config));
    let scene = room(&[Block::new([1.513, -0.4, 0.0], [1.6, 0.4, 0.9])]);
    let wall = dim_wall(WALL[0], -0.5..0.5, 0.7);
    for index in 0..FRAMES {
        rig.see(&frame(index * FRAME_MS, &scene, 0.0));
    }
    rig.see(&scan(300, &wall, 0.0));
    let first = rig.publish(None);
    assert_eq!([first.said(POST), first.said(WALL)], [(6, 254), (7, 50)]);
    // 10 cm a message, to 1 m and back; the lidar sees nothing, and the camera sees holes.
    let holes = DepthSamples::Metres(vec![0.0; 160 * 120]);
    for step in 0..=20_u32 {
        let x_m = 0.1 * f64::from(10 - (i32::try_from(step).unwrap() - 10).abs());
        let ms = 310 + 8 * u64::from(step);
        let observation = if step % 3 == 0 {
            scan(ms, &[], x_m)
        } else {
            let blind = of_samples(CAMERA, ms, holes.clone(), small_camera(), mount(0.0, 0.2));
            Observation { pose: Some(at(x_m, mount(0.0, 0.2))), ..blind }
        };
        rig.see(&observation);
        let out = rig.publish(None);
        assert_eq!([out.said(POST), out.said(WALL)], [(6, 254), (7, 50)], "{x_m} m");
        let shift = ((x_m + BASE_M.x) / 0.05).floor() * 0.05 - 3.0;
        assert!((out.map.grid.origin_x_m - shift).abs() < 1e-9, "the window follows the robot");
    }
    // All that never left the window is as it was.
    let last = rig.publish(None);
    let near = |out: &super::rig::Published| -> Vec<u32> {
        let cells = (0..out.map.verdicts.len()).filter(|&cell| out.centre(cell)[0] > -1.9);
        cells.map(|cell| out.map.verdicts[cell].row()).collect()
    };
    assert_eq!(near(&last), near(&first));
}

#[test]
fn truth_what_leaves_the_window_is_forgotten_by_both() {
    if skipped() {
        return;
    }
    let config = config();
    let mut rig = Rig::open(&config, &camera_and_lidar(&config));
    let scene = room(&[Block::new([1.513, -0.4, 0.0], [1.6, 0.4, 0.9])]);
    for index in 0..FRAMES {
        rig.see(&frame(index * FRAME_MS, &scene, 0.0));
    }
    rig.see(&scan(300, &dim_wall(WALL[0], -0.5..0.5, 0.7), 0.0));
    // Away by more than the map, by the lidar alone, and back by it.
    for (ms, x_m) in [(310, 7.0), (320, 0.0)] {
        rig.see(&scan(ms, &[], x_m));
    }
    let out = rig.publish(None);
    assert!(out.map.verdicts.iter().all(|verdict| verdict.row() == 10));
    // The lidar moved the window for the camera too: its own next frame starts anew there.
    rig.see(&frame(330, &scene, 0.0));
    assert_eq!(rig.publish(None).said(POST).0, 10, "one frame of the post confirms none");
}

#[test]
fn truth_late_messages_from_where_the_robot_was_land_where_it_was_and_leave_the_window() {
    if skipped() {
        return;
    }
    let config = Config { timeout_s: 2.0, ..config() };
    let sensors = camera_and_lidar(&config).map(|sensor| SensorInfo { timeout_s: 2.0, ..sensor });
    let mut rig = Rig::open(&config, &sensors);
    let scene = room(&[Block::new([1.513, -0.4, 0.0], [1.6, 0.4, 0.9])]);
    rig.see(&scan(0, &[], 0.0));
    rig.see(&scan(500, &[], 1.0));
    let before = rig.publish(None);
    for index in 0..FRAMES {
        rig.see(&frame(100 + index * FRAME_MS, &scene, 0.0));
    }
    rig.see(&scan(400, &dim_wall(WALL[0], -0.5..0.5, 0.7), 0.0));
    let out = rig.publish(None);
    assert_eq!(out.map.grid, before.map.grid, "the window stays with the newest");
    assert_eq!(out.stamp_ns, before.stamp_ns);
    assert_eq!([out.said(POST), out.said(WALL), out.said([1.12, 0.02])], [(6, 254), (7, 50), (9, 0)]);
}
