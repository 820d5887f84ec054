//! Observations that the mapper does not take: the others go on, and the map stays as it was.

use limpid::Config;
use limpid::base::Refused;
use limpid::mapper::SensorInfo;

use super::rig::{
    FRAME_MS, FRAMES, Rig, camera, camera_and_lidar, config, dim_wall, frame, half_camera, mount, room,
    sweep, two_cameras,
};
use crate::support::gpu::skipped;
use crate::support::scan::scan;
use crate::support::scene::{Block, Scene, small_camera};

fn scene() -> Scene {
    room(&[Block::new([1.513, -1.0, 0.0], [1.6, 1.0, 0.5])])
}

#[test]
fn a_camera_that_changes_its_size_is_refused_and_the_other_goes_on() {
    if skipped() {
        return;
    }
    let config = config();
    let mut rig = Rig::open(&config, &two_cameras(&config));
    let mount = mount(0.0, 0.2);
    for index in 0..FRAMES {
        let ms = index * FRAME_MS;
        let before = (index > 0).then(|| rig.publish(None));
        let reason = rig.refuse(&frame(0, ms, &scene(), half_camera(), mount));
        assert!(matches!(reason, Refused::Image { what: "depth", .. }), "{reason}");
        if let Some(before) = before {
            assert_eq!(rig.publish(None).map, before.map);
        }
        rig.see(&frame(1, ms, &scene(), small_camera(), mount));
    }
    let out = rig.publish(None);
    assert_eq!((out.said([1.52, 0.02]), out.verdict([1.52, 0.02]).sensor()), ((6, 254), Some(1)));
    // In its own size it is taken again.
    rig.see(&frame(0, 330, &scene(), small_camera(), mount));
    assert_eq!(rig.publish(None).verdict([1.52, 0.02]).sensor(), Some(0));
}

#[test]
fn truth_cameras_of_two_sizes_share_a_map() {
    if skipped() {
        return;
    }
    let config = config();
    let sizes = [small_camera(), half_camera()];
    let sensors = [camera("large", &config, sizes[0], false), camera("small", &config, sizes[1], false)];
    let mut rig = Rig::open(&config, &sensors);
    let scene = room(&[
        Block::new([1.513, -0.4, 0.0], [1.6, 0.4, 0.9]),
        Block::new([-0.4, 1.513, 0.0], [0.4, 1.6, 0.9]),
    ]);
    for index in 0..FRAMES {
        for (sensor, yaw) in [(0, 0.0), (1, 0.5 * std::f64::consts::PI)] {
            rig.see(&frame(sensor, index * FRAME_MS, &scene, sizes[sensor], mount(yaw, 0.2)));
        }
    }
    let out = rig.publish(None);
    for (sensor, post, before, behind) in
        [(0, [1.52, 0.02], [1.12, 0.02], [1.92, 0.02]), (1, [0.02, 1.52], [0.02, 1.12], [0.02, 1.92])]
    {
        assert_eq!((out.said(post), out.verdict(post).sensor()), ((6, 254), Some(sensor)));
        assert_eq!((out.said(before), out.verdict(before).sensor()), ((9, 0), Some(sensor)));
        assert_eq!(out.said(behind).0, 10, "{:?}", out.said(behind));
    }
}

#[test]
fn a_scan_larger_than_max_points_is_refused_and_one_as_large_is_taken() {
    if skipped() {
        return;
    }
    let config = Config { max_points: 100, ..config() };
    let mut rig = Rig::open(&config, &camera_and_lidar(&config));
    let wall = dim_wall(2.52, -0.5..0.51, 0.7);
    assert_eq!(wall.len(), 101);
    rig.see(&frame(0, 0, &scene(), small_camera(), mount(0.0, 0.2)));
    let before = rig.publish(None);
    assert_eq!(rig.refuse(&sweep(1, 10, &wall)), Refused::TooManyPoints { points: 101, most: 100 });
    assert_eq!(rig.publish(None).map.verdicts, before.map.verdicts);
    rig.see(&frame(0, 33, &scene(), small_camera(), mount(0.0, 0.2)));
    rig.see(&sweep(1, 40, &wall[..100]));
    assert_eq!(rig.publish(None).said([2.52, 0.02]), (7, 50));
}

#[test]
fn an_observation_of_no_sensor_or_of_the_other_kind_is_refused() {
    if skipped() {
        return;
    }
    let config = config();
    let mut rig = Rig::open(&config, &camera_and_lidar(&config));
    rig.see(&frame(0, 0, &scene(), small_camera(), mount(0.0, 0.2)));
    let before = rig.publish(None);
    // The number after the last sensor is where the mapper keeps the map's own passes.
    for sensor in [2, 3, 17, usize::MAX] {
        let reason = rig.refuse(&frame(sensor, 10, &scene(), small_camera(), mount(0.0, 0.2)));
        assert_eq!(reason, Refused::Sensor(format!("no sensor {sensor}")));
    }
    for wrong in [sweep(0, 10, &[]), frame(1, 10, &scene(), small_camera(), mount(0.0, 0.2))] {
        assert!(matches!(rig.refuse(&wrong), Refused::Sensor(_)));
    }
    let nowhere = limpid::sensor::Observation { pose: None, ..sweep(1, 10, &[]) };
    assert_eq!(rig.refuse(&nowhere), Refused::NoPose);
    assert_eq!(rig.publish(None).map, before.map);
}

#[test]
fn a_first_scan_larger_than_max_points_raises_it() {
    if skipped() {
        return;
    }
    let config = Config { max_points: 10, ..config() };
    let wall = dim_wall(2.52, -0.5..0.51, 0.7);
    let first = scan(0, vec![crate::support::scan::point([1.0, 0.0, 0.0], 1.0); 101]);
    let lidar = SensorInfo { name: "top".into(), ..SensorInfo::lidar(&config, first) };
    let mut rig = Rig::open(&config, &[camera("front", &config, small_camera(), false), lidar]);
    rig.see(&sweep(1, 0, &wall));
    assert_eq!(rig.publish(None).said([2.52, 0.02]), (7, 50));
}
