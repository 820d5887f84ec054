//! Poses: chains, interpolation, what is missing, odometry; against hand-computed values.

use std::f64::consts::FRAC_PI_2;

use glam::{DQuat, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::config::StaticTransform;
use limpid::input::transforms::{Inserted, TransformBuffer, TransformError};
use limpid::message::ros2::{OdometryPose, Pose, PoseWithCovariance, Quaternion, Vector3};

use super::synthetic::{FRAME, Recorder, at_ms, header};
use super::{noted, read_mcap, skipped};

const NO_ROTATION: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// Optical axes (x right, y down, z forward) in a body's (x forward, y left, z up).
const OPTICAL: [f64; 4] = [-0.5, 0.5, -0.5, 0.5];

fn yaw(angle_rad: f64) -> [f64; 4] {
    DQuat::from_rotation_z(angle_rad).to_array()
}

fn near(a: DVec3, b: [f64; 3]) -> bool {
    a.abs_diff_eq(DVec3::from_array(b), 1e-9)
}

#[test]
fn a_chain_with_different_rates_is_interpolated_edge_by_edge() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf_static", at_ms(0), ["base_link", FRAME], [0.1, 0.0, 0.3], OPTICAL);
    // map -> odom at 1 Hz moves 1 m/s along y; odom -> base_link at 5 Hz turns a quarter in a second.
    for second in 0..3_u32 {
        let y = f64::from(second);
        recorder.transform(
            "/tf",
            at_ms(1000 * u64::from(second)),
            ["map", "odom"],
            [10.0, y, 0.0],
            NO_ROTATION,
        );
    }
    for step in 0..11_u32 {
        let s = f64::from(step) * 0.2;
        recorder.transform(
            "/tf",
            at_ms(200 * u64::from(step)),
            ["odom", "base_link"],
            [2.0 * s, 0.0, 0.0],
            yaw(FRAC_PI_2 * s),
        );
    }
    recorder.depth(at_ms(1250), 7);
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    assert!(report.skipped.is_empty(), "{report:?}");
    let pose = frames[0].pose.unwrap();
    // At 1.25 s: odom at (10, 1.25), base at 2.5 m along x of odom, turned by 1.25 quarters.
    assert!(near(pose.map_from_base.translation_m, [12.5, 1.25, 0.0]), "{pose:?}");
    let facing = pose.map_from_base.rotation * DVec3::X;
    assert!(near(facing, [(1.25 * FRAC_PI_2).cos(), (1.25 * FRAC_PI_2).sin(), 0.0]), "{pose:?}");
    assert!(near(pose.base_from_camera.translation_m, [0.1, 0.0, 0.3]), "{pose:?}");
    assert!(near(pose.base_from_camera.rotation * DVec3::Z, [1.0, 0.0, 0.0]), "{pose:?}");
}

#[test]
fn a_stamp_past_the_newest_transform_waits_and_then_holds_within_the_tolerance() {
    let recording = || {
        let mut recorder = Recorder::new();
        recorder.transform("/tf", at_ms(0), ["map", "base_link"], [1.0, 0.0, 0.0], NO_ROTATION);
        recorder.transform("/tf_static", at_ms(0), ["base_link", FRAME], [0.0, 0.0, 1.0], OPTICAL);
        recorder.depth(at_ms(50), 7);
        recorder.depth(at_ms(150), 7);
        recorder.transform("/tf", at_ms(100), ["map", "base_link"], [2.0, 0.0, 0.0], NO_ROTATION);
        recorder.save()
    };
    let (frames, report) = read_mcap(&recording(), &Config::default()).unwrap();
    assert!(near(frames[0].pose.unwrap().map_from_base.translation_m, [1.5, 0.0, 0.0]));
    assert_eq!(frames[1].pose, None);
    assert_eq!(skipped(&report, "past the newest transform of `base_link`"), 1, "{report:?}");
    let config = Config { transform_tolerance_s: 0.06, ..Config::default() };
    let (frames, report) = read_mcap(&recording(), &config).unwrap();
    assert!(near(frames[0].pose.unwrap().map_from_base.translation_m, [1.5, 0.0, 0.0]));
    assert!(near(frames[1].pose.unwrap().map_from_base.translation_m, [2.0, 0.0, 0.0]));
    assert!(report.skipped.is_empty(), "{report:?}");
}

#[test]
fn a_stamp_before_the_oldest_transform_has_no_pose() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf", at_ms(100), ["map", FRAME], [1.0, 0.0, 0.0], NO_ROTATION);
    recorder.depth(at_ms(50), 7);
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    assert_eq!(frames[0].pose, None);
    assert_eq!(skipped(&report, "before the oldest transform"), 1, "{report:?}");
}

#[test]
fn leading_slashes_of_frames_do_not_matter() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf", at_ms(0), ["/map", "/cam_optical"], [1.0, 0.0, 0.0], OPTICAL);
    recorder.depth(at_ms(0), 7);
    let (frames, _) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    assert_eq!(frames[0].depth.frame_id, FRAME);
    assert!(near(frames[0].pose.unwrap().map_from_base.translation_m, [1.0, 0.0, 0.0]));
}

#[test]
fn transforms_that_are_none_are_counted() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf", at_ms(0), ["map", FRAME], [1.0, 0.0, 0.0], [0.0; 4]);
    recorder.transform("/tf", at_ms(0), ["map", FRAME], [f64::NAN, 0.0, 0.0], NO_ROTATION);
    recorder.depth(at_ms(0), 7);
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    assert_eq!(frames[0].pose, None);
    assert_eq!(
        skipped(&report, "the transform of `cam_optical` is not finite or has no rotation"),
        2,
        "{report:?}"
    );
}

#[test]
fn a_looped_recording_does_not_interpolate_across_the_jump() {
    let mut recorder = Recorder::new();
    for (ms, x) in [(5000, 50.0), (5100, 51.0), (0, 0.0), (100, 1.0)] {
        recorder.transform("/tf", at_ms(ms), ["map", FRAME], [x, 0.0, 0.0], OPTICAL);
        recorder.depth(at_ms(ms), 7);
    }
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    let x: Vec<f64> = frames.iter().map(|frame| frame.pose.unwrap().map_from_base.translation_m.x).collect();
    assert_eq!(x, [50.0, 51.0, 0.0, 1.0]);
    assert!(noted(&report, "transform stamps jumped back"), "{:?}", report.notes);
}

fn odometry(stamp_ns: u64, frames: [&str; 2], x: f64) -> OdometryPose {
    let pose = Pose {
        position: Vector3 { x, y: 0.0, z: 0.0 },
        orientation: Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 },
    };
    OdometryPose {
        header: header(stamp_ns, frames[0]),
        child_frame_id: frames[1].into(),
        pose: PoseWithCovariance { pose, covariance: [[0.0; 6]; 6] },
    }
}

#[test]
fn odometry_takes_the_place_of_tf_for_the_base() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf_static", at_ms(0), ["base_link", FRAME], [0.0, 0.0, 1.0], OPTICAL);
    for (ms, x) in [(0, 0.0), (100, 1.0)] {
        recorder.transform("/tf", at_ms(ms), ["map", "base_link"], [-9.0, 0.0, 0.0], NO_ROTATION);
        recorder.ros(
            "/odom",
            "nav_msgs/msg/Odometry",
            at_ms(ms),
            &odometry(at_ms(ms), ["odom", "base_link"], x),
        );
    }
    recorder.depth(at_ms(25), 7);
    let saved = recorder.save();
    let config = Config { odometry_topic: "/odom".into(), map_frame: "odom".into(), ..Config::default() };
    let (frames, report) = read_mcap(&saved, &config).unwrap();
    assert!(near(frames[0].pose.unwrap().map_from_base.translation_m, [0.25, 0.0, 0.0]), "{report:?}");
    assert!(!noted(&report, "odometry gives"), "{:?}", report.notes);
    let config = Config { odometry_topic: "/odom".into(), ..Config::default() };
    let (frames, report) = read_mcap(&saved, &config).unwrap();
    assert_eq!(frames[0].pose, None);
    assert!(
        noted(&report, "odometry gives `odom` from `base_link`, not `map` from `base_link`"),
        "{:?}",
        report.notes
    );
}

#[test]
fn odometry_of_another_frame_leaves_the_base_its_fixed_transform() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf_static", at_ms(0), ["base_link", FRAME], [0.0, 0.0, 1.0], OPTICAL);
    // Comes once, before odometry says that it does not give the base.
    recorder.transform("/tf_static", at_ms(0), ["base_footprint", "base_link"], [0.0, 0.0, 0.1], NO_ROTATION);
    for (ms, x) in [(0, 0.0), (100, 1.0)] {
        let message = odometry(at_ms(ms), ["odom", "base_footprint"], x);
        recorder.ros("/odom", "nav_msgs/msg/Odometry", at_ms(ms), &message);
    }
    recorder.depth(at_ms(25), 7);
    let config = Config { odometry_topic: "/odom".into(), map_frame: "odom".into(), ..Config::default() };
    let (frames, report) = read_mcap(&recorder.save(), &config).unwrap();
    let pose = frames[0].pose.unwrap_or_else(|| panic!("{report:?}"));
    assert!(near(pose.map_from_base.translation_m, [0.25, 0.0, 0.1]), "{pose:?}");
}

#[test]
fn a_stated_base_serves_where_the_recording_knows_only_its_camera() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf", at_ms(0), ["map", FRAME], [4.0, 0.0, 1.0], OPTICAL);
    recorder.depth(at_ms(0), 7);
    let stated = StaticTransform {
        parent: "base_link".into(),
        child: FRAME.into(),
        translation_m: [0.5, 0.0, 1.0],
        rotation_xyzw: OPTICAL,
    };
    let config = Config { static_transforms: vec![stated], ..Config::default() };
    let (frames, report) = read_mcap(&recorder.save(), &config).unwrap();
    let pose = frames[0].pose.unwrap();
    assert!(near(pose.map_from_base.translation_m, [3.5, 0.0, 0.0]), "{pose:?}");
    assert!(near(pose.base_from_camera.translation_m, [0.5, 0.0, 1.0]), "{pose:?}");
    assert!(noted(&report, "its own transform of `cam_optical`"), "{:?}", report.notes);
}

#[test]
fn a_stated_transform_without_rotation_is_refused() {
    let mut recorder = Recorder::new();
    recorder.depth(at_ms(0), 7);
    let stated = StaticTransform {
        parent: "base_link".into(),
        child: FRAME.into(),
        translation_m: [0.0; 3],
        rotation_xyzw: [0.0; 4],
    };
    let config = Config { static_transforms: vec![stated], ..Config::default() };
    let error = read_mcap(&recorder.save(), &config).unwrap_err().to_string();
    assert!(error.contains("static_transforms") && error.contains(FRAME), "{error}");
}

fn shift(x: f64) -> Rigid {
    Rigid::new([x, 0.0, 0.0], NO_ROTATION).unwrap()
}

#[test]
fn the_buffer_tells_its_errors_apart() {
    let mut buffer = TransformBuffer::new();
    buffer.insert("map", "odom", 100, shift(1.0));
    buffer.insert("map", "odom", 200, shift(2.0));
    buffer.insert("a", "b", 0, shift(0.0));
    buffer.insert("b", "a", 0, shift(0.0));
    let child = || "odom".to_owned();
    assert_eq!(buffer.lookup("map", "odom", 50, 0), Err(TransformError::Past { child: child() }));
    assert_eq!(buffer.lookup("map", "odom", 201, 0), Err(TransformError::Future { child: child() }));
    assert_eq!(buffer.lookup("map", "odom", 201, 1), Ok(shift(2.0)));
    assert_eq!(buffer.lookup("map", "nowhere", 150, 0), Err(TransformError::Disconnected));
    assert_eq!(buffer.lookup("a", "b", 0, 0), Err(TransformError::Loop { frame: "b".into() }));
    assert_eq!(buffer.lookup("odom", "map", 150, 0).unwrap().translation_m.x, -1.5);
    assert_eq!(buffer.lookup("odom", "odom", 0, 0), Ok(Rigid::IDENTITY));
}

#[test]
fn a_loop_counts_only_while_it_is_told() {
    let mut buffer = TransformBuffer::new();
    buffer.insert("map", "base", 100, shift(1.0));
    buffer.insert("base", "camera", 100, shift(2.0));
    buffer.insert("camera", "map", 100, shift(3.0));
    let at = |buffer: &TransformBuffer, stamp_ns| buffer.lookup("map", "camera", stamp_ns, 10);
    assert_eq!(at(&buffer, 100), Err(TransformError::Loop { frame: "camera".into() }));
    assert!(buffer.newest_ns("camera") == Some(100));
    // One publisher goes on, the one that closed the loop does not.
    buffer.insert("map", "base", 200, shift(1.0));
    buffer.insert("base", "camera", 200, shift(2.0));
    assert_eq!(at(&buffer, 200), Ok(shift(3.0)));
    assert_eq!(at(&buffer, 105), Err(TransformError::Loop { frame: "camera".into() }));
}

#[test]
fn the_buffer_is_bounded_and_fixed_transforms_stay() {
    let mut buffer = TransformBuffer::new();
    for second in 0..100_u32 {
        buffer.insert("map", "odom", u64::from(second) * 1_000_000_000, shift(f64::from(second)));
    }
    assert!(buffer.lookup("map", "odom", 89_000_000_000, 0).is_ok());
    assert!(buffer.lookup("map", "odom", 80_000_000_000, 0).is_err());
    assert!(buffer.jumps_back("odom", 97_999_999_999) && !buffer.jumps_back("odom", 98_000_000_000));
    assert_eq!(buffer.insert_fixed("base", "camera", shift(1.0)), Inserted::Taken);
    assert_eq!(buffer.insert("base", "camera", 5, shift(2.0)), Inserted::Ignored);
    buffer.clear_samples();
    assert_eq!(buffer.lookup("base", "camera", 7, 0), Ok(shift(1.0)));
    assert!(!buffer.knows("odom") && buffer.knows("base"));
    let many = (0..10_000).map(|n| buffer.insert("base", &format!("f{n}"), 0, shift(0.0)));
    assert_eq!(many.filter(|&inserted| inserted == Inserted::Taken).count(), 4095);
}
