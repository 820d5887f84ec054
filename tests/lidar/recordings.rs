//! Poses, goals and a camera beside the lidar, out of MCAP files that the tests write.

use std::f64::consts::FRAC_PI_2;
use std::process::Command;

use glam::{DQuat, DVec2, DVec3};
use limpid::Config;
use limpid::input::PosedScans;
use limpid::lidar::ScanFrame;
use limpid::message::ros2::{
    OdometryPose, PointCloud2, PointField, Pose, PoseStamped, PoseWithCovariance, Vector3,
};

use crate::read::synthetic::{FRAME, Recorder, Saved, at_ms, header};
use crate::support::gpu::skipped;
use crate::support::scan::run_one;

const NO_ROTATION: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// Ten bright points ahead, the last one taken `last_s` after the stamp.
fn record_cloud(recorder: &mut Recorder, ms: u64, last_s: f32) {
    let names = ["x", "y", "z", "intensity", "time"];
    let field =
        |(at, name): (u32, &str)| PointField { name: name.into(), offset: 4 * at, datatype: 7, count: 1 };
    let point = |i: u8| [2.05, f32::from(i) * 0.1 - 0.45, 0.1, 200.0, last_s * f32::from(i) / 9.0];
    let message = PointCloud2 {
        header: header(at_ms(ms), "lidar"),
        height: 1,
        width: 10,
        fields: (0..).zip(names).map(field).collect(),
        is_bigendian: 0,
        point_step: 20,
        row_step: 200,
        data: (0..10).flat_map(point).flat_map(f32::to_le_bytes).collect(),
        is_dense: 1,
    };
    recorder.ros("/points", "sensor_msgs/msg/PointCloud2", at_ms(ms), &message);
}

fn frames(saved: &Saved, config: &Config) -> Vec<ScanFrame> {
    let mut scans = PosedScans::open(&saved.path, config).unwrap();
    std::iter::from_fn(|| scans.next_frame().unwrap()).collect()
}

fn near(got: DVec3, want: [f64; 3]) -> bool {
    got.abs_diff_eq(DVec3::from_array(want), 1e-6)
}

#[test]
fn a_goal_of_a_topic_is_taken_from_its_stamp_on_and_into_the_map() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf_static", at_ms(0), ["base_link", "lidar"], [0.0, 0.0, 0.5], NO_ROTATION);
    let quarter = DQuat::from_rotation_z(FRAC_PI_2).to_array();
    let place = |recorder: &mut Recorder, ms: u64| {
        recorder.transform("/tf", at_ms(ms), ["map", "odom"], [0.0, 1.0, 0.0], quarter);
        recorder.transform("/tf", at_ms(ms), ["odom", "base_link"], [0.0; 3], NO_ROTATION);
    };
    place(&mut recorder, 0);
    record_cloud(&mut recorder, 0, 0.0);
    let pose = Pose { position: Vector3 { x: 5.0, y: 0.0, z: 0.0 }, ..Pose::default() };
    let goal = PoseStamped { header: header(at_ms(50), "odom"), pose };
    recorder.ros("/goal", "geometry_msgs/msg/PoseStamped", at_ms(50), &goal);
    record_cloud(&mut recorder, 100, 0.0);
    place(&mut recorder, 200);
    let saved = recorder.save();
    let config = Config { goal_topic: "/goal".into(), ..Config::default() };
    let found = frames(&saved, &config);
    // Five metres along x of odom, which lies along y of the map.
    let goals: Vec<Option<DVec2>> = found.iter().map(|frame| frame.goal_m).collect();
    assert_eq!(goals[0], None);
    assert!(goals[1].unwrap().abs_diff_eq(DVec2::new(0.0, 6.0), 1e-6), "{goals:?}");
    assert!(frames(&saved, &Config::default()).iter().all(|frame| frame.goal_m.is_none()), "none asked for");
    if !skipped() {
        let towards = run_one(&config, &found[1]).towards_goal.unwrap();
        assert!(towards.abs_diff_eq(DVec2::Y, 1e-6), "{towards}");
    }
}

#[test]
fn odometry_moves_the_lidar() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf_static", at_ms(0), ["base_link", "lidar"], [0.2, 0.0, 1.0], NO_ROTATION);
    for (ms, x) in [(0, 0.0), (100, 1.0)] {
        let pose = Pose { position: Vector3 { x, y: 0.0, z: 0.0 }, ..Pose::default() };
        let message = OdometryPose {
            header: header(at_ms(ms), "odom"),
            child_frame_id: "base_link".into(),
            pose: PoseWithCovariance { pose, covariance: [[0.0; 6]; 6] },
        };
        recorder.ros("/odom", "nav_msgs/msg/Odometry", at_ms(ms), &message);
    }
    record_cloud(&mut recorder, 25, 0.0);
    let config = Config { odometry_topic: "/odom".into(), map_frame: "odom".into(), ..Config::default() };
    let found = frames(&recorder.save(), &config);
    assert_eq!(found[0].map_frame, "odom");
    let pose = found[0].pose.unwrap();
    assert!(near(pose.map_from_base.translation_m, [0.25, 0.0, 0.0]), "{pose:?}");
    assert!(near(pose.map_from_lidar().translation_m, [0.45, 0.0, 1.0]), "{pose:?}");
}

#[test]
fn transforms_are_interpolated_at_the_stamp_and_at_the_first_and_last_point() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf_static", at_ms(0), ["base_link", "lidar"], [0.0, 0.0, 1.0], NO_ROTATION);
    // A metre and a quarter turn in a tenth of a second.
    for (ms, share) in [(0, 0.0), (100, 1.0)] {
        let turn = DQuat::from_rotation_z(FRAC_PI_2 * share).to_array();
        recorder.transform("/tf", at_ms(ms), ["map", "base_link"], [share, 0.0, 0.0], turn);
    }
    record_cloud(&mut recorder, 40, 0.05);
    record_cloud(&mut recorder, 400, 0.05);
    let found = frames(&recorder.save(), &Config::default());
    let pose = found[0].pose.unwrap();
    assert!(near(pose.map_from_base.translation_m, [0.4, 0.0, 0.0]), "{pose:?}");
    let facing = pose.map_from_base.rotation * DVec3::X;
    assert!(near(facing, [(0.4 * FRAC_PI_2).cos(), (0.4 * FRAC_PI_2).sin(), 0.0]), "{pose:?}");
    let sweep = pose.sweep.unwrap();
    assert!(near(sweep.map_from_first.translation_m, [0.4, 0.0, 1.0]), "{sweep:?}");
    assert!(near(sweep.map_from_last.translation_m, [0.9, 0.0, 1.0]), "{sweep:?}");
    assert_eq!(found[1].pose, None, "long after the newest transform");
}

#[test]
fn a_camera_and_a_lidar_lose_nothing_to_each_other() {
    if skipped() {
        return;
    }
    let mut recorder = Recorder::new();
    recorder.transform("/tf_static", at_ms(0), ["base_link", FRAME], [0.0, 0.0, 1.0], [-0.5, 0.5, -0.5, 0.5]);
    recorder.transform("/tf_static", at_ms(0), ["base_link", "lidar"], [0.0, 0.0, 1.0], NO_ROTATION);
    for ms in [0, 200] {
        recorder.transform("/tf", at_ms(ms), ["map", "base_link"], [0.0; 3], NO_ROTATION);
    }
    for ms in [10, 110] {
        recorder.depth(at_ms(ms), 900);
        record_cloud(&mut recorder, ms + 20, 0.0);
    }
    let saved = recorder.save();
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let run = |sensor: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
        command.arg("run").arg(&saved.path).args(sensor);
        command.arg("-o").arg(path("out.mcap")).arg("--png").arg(path("png"));
        let output = command.arg("--dump").arg(path("dump")).arg("--map").arg(path("map")).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    run(&[]);
    let mut expected = vec!["map.pgm", "map.yaml", "map-plan.pgm", "map-plan.yaml"];
    for name in ["png/000001-costmap.png", "png/000001-plan.png", "dump/000001/frame.json"] {
        expected.push(name);
    }
    expected.extend(["dump/lidar/000001/frame.json", "dump/lidar/000001/class.exr"]);
    for name in expected {
        assert!(path(name).is_file(), "{name}");
    }
    let bytes = std::fs::read(path("out.mcap")).unwrap();
    let mut topics = std::collections::BTreeMap::<String, usize>::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        *topics.entry(message.unwrap().channel.topic.clone()).or_default() += 1;
    }
    let of =
        |part: &str| topics.iter().filter(|(topic, _)| topic.contains(part)).map(|(_, count)| *count).max();
    assert_eq!((of("costmap"), of("plan")), (Some(2), Some(2)), "{topics:?}");
    let camera_map = std::fs::read(path("map.pgm")).unwrap();
    run(&["--sensor", "camera"]);
    assert_eq!(std::fs::read(path("map.pgm")).unwrap(), camera_map, "the same map alone");
}
