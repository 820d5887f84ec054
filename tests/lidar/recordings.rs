//! Poses, goals and a camera beside the lidar, out of MCAP files that the tests write.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::path::Path;
use std::process::Command;

use crate::support::scan::ScanFrame;
use byteorder::LittleEndian;
use glam::{DQuat, DVec2, DVec3};
use limpid::Config;
use limpid::input::PosedScans;
use limpid::message::ros2::{
    OdometryPose, PointCloud2, PointField, Pose, PoseStamped, PoseWithCovariance, TFMessage, Vector3,
};
use serde_bytes::ByteBuf;

use crate::read::synthetic::{FRAME, Recorder, Saved, at_ms, header, transform};
use crate::support::gpu::skipped;
use crate::support::scan::run_one;

const NO_ROTATION: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// Ten bright points ahead, the last one taken `last_s` after the stamp.
fn record_cloud(recorder: &mut Recorder, ms: u64, last_s: f32) {
    record_cloud_at(recorder, at_ms(ms), at_ms(ms), [0.0, last_s]);
}

/// As [`record_cloud`], logged at another time than it is stamped with; times of the first and the last point.
fn record_cloud_at(recorder: &mut Recorder, log_ns: u64, stamp_ns: u64, [first_s, last_s]: [f32; 2]) {
    let names = ["x", "y", "z", "intensity", "time"];
    let field =
        |(at, name): (u32, &str)| PointField { name: name.into(), offset: 4 * at, datatype: 7, count: 1 };
    let point = |i: u8| {
        [2.05, f32::from(i) * 0.1 - 0.45, 0.1, 200.0, first_s + (last_s - first_s) * f32::from(i) / 9.0]
    };
    let message = PointCloud2 {
        header: header(stamp_ns, "lidar"),
        height: 1,
        width: 10,
        fields: (0..).zip(names).map(field).collect(),
        is_bigendian: 0,
        point_step: 20,
        row_step: 200,
        data: (0..10).flat_map(point).flat_map(f32::to_le_bytes).collect(),
        is_dense: 1,
    };
    recorder.ros("/points", "sensor_msgs/msg/PointCloud2", log_ns, &message);
}

/// The base of the map at x metres, logged at another time than it is stamped with.
fn record_base_at(recorder: &mut Recorder, log_ns: u64, stamp_ns: u64, x: f64) {
    let transforms = vec![transform(stamp_ns, ["map", "base_link"], [x, 0.0, 0.0], NO_ROTATION)];
    recorder.ros("/tf", "tf2_msgs/msg/TFMessage", log_ns, &TFMessage { transforms });
}

fn record_odometry(recorder: &mut Recorder, ms: u64, child: &str, x: f64) {
    let pose = Pose { position: Vector3 { x, y: 0.0, z: 0.0 }, ..Pose::default() };
    let message = OdometryPose {
        header: header(at_ms(ms), "odom"),
        child_frame_id: child.into(),
        pose: PoseWithCovariance { pose, covariance: [[0.0; 6]; 6] },
    };
    recorder.ros("/odom", "nav_msgs/msg/Odometry", at_ms(ms), &message);
}

fn frames(saved: &Saved, config: &Config) -> Vec<ScanFrame> {
    let mut scans = PosedScans::open(&saved.path, config).unwrap();
    std::iter::from_fn(|| scans.next_observation().unwrap().map(ScanFrame::from)).collect()
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
        record_odometry(&mut recorder, ms, "base_link", x);
    }
    record_cloud(&mut recorder, 25, 0.0);
    let config = Config { odometry_topic: "/odom".into(), map_frame: "odom".into(), ..Config::default() };
    let found = frames(&recorder.save(), &config);
    assert_eq!(found[0].map_frame, "odom");
    let pose = found[0].pose.unwrap();
    assert!(near(pose.map_from_base.translation_m, [0.25, 0.0, 0.0]), "{pose:?}");
    assert!(near(pose.map_from_sensor().translation_m, [0.45, 0.0, 1.0]), "{pose:?}");
}

#[test]
fn odometry_takes_the_place_of_tf_s_own_transform() {
    let config = Config { odometry_topic: "/odom".into(), map_frame: "odom".into(), ..Config::default() };
    for child in ["base_link", "base_footprint"] {
        let mut recorder = Recorder::new();
        recorder.transform("/tf_static", at_ms(0), ["base_link", "lidar"], [0.2, 0.0, 1.0], NO_ROTATION);
        if child != "base_link" {
            // Comes once, before odometry has said that it does not give the base.
            recorder.transform("/tf_static", at_ms(0), [child, "base_link"], [0.0, 0.0, 0.1], NO_ROTATION);
        }
        for (ms, x) in [(0, 0.0), (100, 1.0)] {
            record_odometry(&mut recorder, ms, child, x);
            recorder.transform("/tf", at_ms(ms), ["odom", child], [-9.0, 0.0, 0.0], NO_ROTATION);
            recorder.transform("/tf", at_ms(ms + 10), ["odom", child], [-9.0, 0.0, 0.0], NO_ROTATION);
        }
        record_cloud(&mut recorder, 25, 0.0);
        let saved = recorder.save();
        let mut scans = PosedScans::open(&saved.path, &config).unwrap();
        let frame = scans.next_observation().unwrap().map(ScanFrame::from).unwrap();
        let z = if child == "base_link" { 0.0 } else { 0.1 };
        let base_m = frame.pose.unwrap().map_from_base.translation_m;
        assert!(near(base_m, [0.25, 0.0, z]), "{child}: {base_m}");
        let told = scans.report().read.notes.iter().any(|note| note.contains("odometry gives `odom` from"));
        assert_eq!(told, child != "base_link", "{:?}", scans.report().read.notes);
    }
}

#[test]
fn stamps_may_lie_far_from_the_log_s_time() {
    // Thirty seconds, three times the window of the transform buffer, at x = t; simulated and replayed stamps.
    for stamp_of_start_ns in [1, 1_000_000_000_000, 3_000_000_000_000_000] {
        let mut recorder = Recorder::new();
        recorder.transform("/tf_static", at_ms(0), ["base_link", "lidar"], [0.0, 0.0, 1.0], NO_ROTATION);
        for ms in (0..=30_000).step_by(50) {
            let stamp_ns = stamp_of_start_ns + ms * 1_000_000;
            record_base_at(&mut recorder, at_ms(ms), stamp_ns, ms as f64 * 1e-3);
            if ms % 200 == 100 {
                record_cloud_at(&mut recorder, at_ms(ms) + 1_000_000, stamp_ns + 20_000_000, [0.0; 2]);
            }
        }
        let found = frames(&recorder.save(), &Config::default());
        assert_eq!(found.len(), 150);
        for (i, frame) in (0_u32..).zip(found) {
            let pose = frame.pose.unwrap_or_else(|| panic!("scan {i} from {stamp_of_start_ns} ns on"));
            assert!(
                near(pose.map_from_base.translation_m, [f64::from(i) * 0.2 + 0.12, 0.0, 0.0]),
                "{pose:?}"
            );
        }
    }
}

#[test]
fn a_scan_without_a_pose_costs_no_other_its_own() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf_static", at_ms(0), ["base_link", "lidar"], [0.0, 0.0, 1.0], NO_ROTATION);
    for ms in (1000..=31_000).step_by(50) {
        record_base_at(&mut recorder, at_ms(ms), at_ms(ms), ms as f64 * 1e-3);
        if ms % 1000 == 0 {
            // The first lies before all transforms: reading on to the end for it would push the others' out of the window.
            let stamp_ns = if ms == 1000 { at_ms(500) } else { at_ms(ms) };
            record_cloud_at(&mut recorder, at_ms(ms), stamp_ns, [0.0; 2]);
        }
    }
    let found = frames(&recorder.save(), &Config::default());
    assert_eq!((found.len(), found[0].pose), (31, None));
    for (second, frame) in (2_u32..).zip(&found[1..]) {
        let pose = frame.pose.unwrap_or_else(|| panic!("second {second}"));
        assert!(near(pose.map_from_base.translation_m, [f64::from(second), 0.0, 0.0]), "{pose:?}");
    }
}

#[test]
fn a_scan_may_be_stamped_after_its_last_point() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf_static", at_ms(0), ["base_link", "lidar"], [0.0, 0.0, 1.0], NO_ROTATION);
    for ms in (0..=300).step_by(10) {
        record_base_at(&mut recorder, at_ms(ms), at_ms(ms), ms as f64 * 1e-3);
        if ms == 200 {
            record_cloud_at(&mut recorder, at_ms(205), at_ms(205), [-0.12, -0.02]);
        }
    }
    let found = frames(&recorder.save(), &Config::default());
    let pose = found[0].pose.unwrap();
    assert!(near(pose.map_from_base.translation_m, [0.205, 0.0, 0.0]), "{pose:?}");
    let sweep = pose.sweep.unwrap();
    assert!(near(sweep.map_from_first.translation_m, [0.085, 0.0, 1.0]), "{sweep:?}");
    assert!(near(sweep.map_from_last.translation_m, [0.185, 0.0, 1.0]), "{sweep:?}");
}

#[test]
fn bad_transforms_are_counted_and_a_jump_of_their_stamps_is_noted() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf_static", at_ms(0), ["base_link", "lidar"], [0.0, 0.0, 1.0], NO_ROTATION);
    // A recording of five seconds, looped twice: the log's time goes on.
    for round in 0..2 {
        for ms in (0..=5000).step_by(50) {
            let log_ns = at_ms(5100 * round + ms);
            record_base_at(&mut recorder, log_ns, at_ms(ms), (ms + 10_000 * round) as f64 * 1e-3);
            if ms == 2500 {
                record_base_at(&mut recorder, log_ns, at_ms(ms + 10), f64::NAN);
                record_cloud_at(&mut recorder, log_ns, at_ms(ms), [0.0; 2]);
            }
        }
    }
    let saved = recorder.save();
    let mut scans = PosedScans::open(&saved.path, &Config::default()).unwrap();
    let found: Vec<ScanFrame> =
        std::iter::from_fn(|| scans.next_observation().unwrap().map(ScanFrame::from)).collect();
    let x_m: Vec<f64> = found.iter().map(|frame| frame.pose.unwrap().map_from_base.translation_m.x).collect();
    assert!((x_m[0] - 2.5).abs() < 1e-9 && (x_m[1] - 12.5).abs() < 1e-9, "{x_m:?}");
    let report = scans.report().read;
    let bad = report.skipped.iter().find(|skip| skip.reason.contains("`base_link` is not finite"));
    assert_eq!(bad.map(|skip| (skip.source.as_str(), skip.count)), Some(("/tf", 2)), "{:?}", report.skipped);
    assert!(
        report.notes.iter().any(|note| note.contains("transform stamps jumped back")),
        "{:?}",
        report.notes
    );
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

/// Results of `limpid run` with all outputs: its words, the topics with their numbers of messages, and the last map.
struct Ran {
    said: String,
    topics: BTreeMap<String, usize>,
    map: Option<Costmap>,
}

type Place = ([f64; 3], [f64; 4]);
type Costmap = (((i32, u32), String), ((i32, u32), (i32, u32), String, f32, u32, u32, Place), ByteBuf);

fn run_all(recording: &Path, folder: &Path, sensor: &[&str]) -> Ran {
    let path = |name: &str| folder.join(name);
    let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
    command.arg("run").arg(recording).args(sensor).arg("-o").arg(path("out.mcap"));
    command.arg("--png").arg(path("png")).arg("--dump").arg(path("dump"));
    let output = command.arg("--map").arg(path("map")).output().unwrap();
    let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert!(output.status.success(), "{said}");
    let bytes = std::fs::read(path("out.mcap")).unwrap();
    let (mut topics, mut map) = (BTreeMap::<String, usize>::new(), None);
    for message in mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap) {
        *topics.entry(message.channel.topic.clone()).or_default() += 1;
        if message.channel.topic == "/limpid/costmap_raw" {
            map = Some(cdr_encoding::from_bytes::<Costmap, LittleEndian>(&message.data[4..]).unwrap().0);
        }
    }
    Ran { said, topics, map }
}

impl Ran {
    /// Side of a cell, metres, and the places of the middles of lethal cells.
    fn lethal(&self) -> (f64, Vec<[f64; 2]>) {
        let (_, (.., resolution, columns, _, (corner_m, _)), costs) = self.map.as_ref().unwrap();
        let (cell_m, columns) = (f64::from(*resolution), *columns as usize);
        let lethal = (0..costs.len()).filter(|&cell| costs[cell] == 254);
        let middle = |number: usize, axis: usize| corner_m[axis] + (number as f64 + 0.5) * cell_m;
        (cell_m, lethal.map(|cell| [middle(cell % columns, 0), middle(cell / columns, 1)]).collect())
    }

    /// Whether a lethal cell has its middle within a square around a place.
    fn is_lethal(&self, [x_m, y_m]: [f64; 2], half_m: f64) -> bool {
        let within = |a: f64, b: f64| (a - b).abs() < half_m;
        self.lethal().1.iter().any(|&[x, y]| within(x, x_m) && within(y, y_m))
    }
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
    // Frames at 50 Hz, as an occupied cell takes some of them, and scans at 10 Hz.
    for ms in (10..=170).step_by(20) {
        recorder.depth(at_ms(ms), 900);
        if ms % 100 == 10 {
            record_cloud(&mut recorder, ms + 5, 0.0);
        }
    }
    let saved = recorder.save();
    let folders = [(); 3].map(|()| tempfile::tempdir().unwrap());
    let both = run_all(&saved.path, folders[0].path(), &[]);
    assert!(both.said.contains("camera: 9 used, 0 without a pose"), "{}", both.said);
    assert!(both.said.contains("lidar: 2 used, 0 without a pose"), "{}", both.said);
    // The first observation's map, one 0.1 s on, and one of what came after it.
    let maps = both.topics["/limpid/costmap"];
    assert_eq!(maps, 3, "{:?}", both.topics);
    assert!(!both.topics.keys().any(|topic| topic.contains("plan")), "{:?}", both.topics);
    for name in ["map.pgm", "map.yaml", "png/map-000002-map.png", "png/camera-000008-reliability.png"] {
        assert!(folders[0].path().join(name).is_file(), "{name}");
    }
    for name in ["map/000002/reason.exr", "camera/000008/occupancy.exr", "lidar/000001/true_positive.exr"] {
        assert!(folders[0].path().join("dump").join(name).is_file(), "{name}");
    }
    assert!(!folders[0].path().join("map-plan.pgm").exists());
    // Each alone: what is lethal then is so in the one map.
    let camera = run_all(&saved.path, folders[1].path(), &["--sensor", "camera"]);
    assert!(camera.said.contains("camera: 9 used") && !camera.said.contains("lidar: 2"), "{}", camera.said);
    let lidar = run_all(&saved.path, folders[2].path(), &["--sensor", "lidar"]);
    assert!(lidar.said.contains("lidar: 2 used") && !lidar.said.contains("camera: 9"), "{}", lidar.said);
    for (name, alone) in [("camera", &camera), ("lidar", &lidar)] {
        let (cell_m, places) = alone.lethal();
        assert!(places.len() > 2, "{name}: {places:?}");
        for place in places {
            assert!(both.is_lethal(place, cell_m / 2.0), "{name}: {place:?} is lethal alone, not together");
        }
    }
    assert!(!both.is_lethal([1.5, 0.0], 0.2), "the control: between what the two see");
}
