//! Real recordings against figures from the reference Python readers
//! (tests/reference/rgbd_recordings.py, stored in testdata/reference).

use std::path::Path;

use glam::{DMat3, DMat4, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::input::{LogReader, Recording, TumReader, open};
use limpid::sensor::{DepthSamples, FramePose, RgbdFrame};
use serde_json::Value;

use super::read_all;
use crate::support::data_dir;

/// Poses come as f64 through both readers; quaternions are normalised once more here.
const POSE_TOLERANCE: f64 = 1e-9;

/// JPEG decoders may round differently, by less than a level on the mean of an image.
const MEAN_TOLERANCE: f64 = 0.5;

fn reference(recording: &str) -> Value {
    let text = std::fs::read_to_string("testdata/reference/rgbd_recordings.json").unwrap();
    serde_json::from_str::<Value>(&text).unwrap()[recording].take()
}

fn integers(frame: &RgbdFrame) -> &[u16] {
    match &frame.depth.samples {
        DepthSamples::Integer { raw, unit_m } => {
            assert_eq!(*unit_m, 0.001);
            raw
        }
        DepthSamples::Metres(_) => panic!("integers were recorded"),
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts of pixels")]
fn assert_depth(frame: &RgbdFrame, row: &Value) {
    let raw = integers(frame);
    assert_eq!(frame.depth.stamp_ns, row["stamp_ns"].as_u64().unwrap());
    assert_eq!(u64::from(frame.depth.camera.width), row["size"][0].as_u64().unwrap());
    assert_eq!(u64::from(frame.depth.camera.height), row["size"][1].as_u64().unwrap());
    let holes = raw.iter().filter(|&&sample| sample == 0 || sample == 65535).count();
    assert!((holes as f64 / raw.len() as f64 - row["holes"].as_f64().unwrap()).abs() < 1e-12);
    let checksum: u64 = (1..).zip(raw).map(|(number, &sample)| number * u64::from(sample)).sum();
    assert_eq!(checksum, row["checksum"].as_u64().unwrap(), "samples differ");
}

#[expect(clippy::cast_precision_loss, reason = "counts of pixels")]
fn assert_color(frame: &RgbdFrame, row: &Value) {
    let color = frame.color.as_ref().unwrap();
    assert_eq!(color.stamp_ns, row["stamp_ns"].as_u64().unwrap());
    assert_eq!(color.rgb.len(), 3 * (color.camera.width * color.camera.height) as usize);
    for channel in 0..3 {
        let values = color.rgb.iter().skip(channel).step_by(3);
        let mean = values.map(|&value| f64::from(value)).sum::<f64>() / (color.rgb.len() / 3) as f64;
        let expected = row["mean_rgb"][channel].as_f64().unwrap();
        assert!((mean - expected).abs() < MEAN_TOLERANCE, "channel {channel}: {mean} against {expected}");
    }
}

fn assert_intrinsics(frame: &RgbdFrame, row: &Value) {
    let camera = frame.depth.camera;
    let expected = [0, 1, 2, 3].map(|at| row[at].as_f64().unwrap());
    for (found, expected) in [camera.fx, camera.fy, camera.cx, camera.cy].iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{camera:?} against {expected}");
    }
}

/// Largest difference between a transform and a stored 4x4 matrix.
fn difference(found: Rigid, row: &Value) -> f64 {
    let at = |i: usize, j: usize| row["first_from_last"][i][j].as_f64().unwrap();
    let rotation = DMat3::from_cols_array_2d(&[0, 1, 2].map(|j| [at(0, j), at(1, j), at(2, j)]));
    let expected = mat4(rotation, DVec3::new(at(0, 3), at(1, 3), at(2, 3)));
    let found = DMat4::from_rotation_translation(found.rotation, found.translation_m);
    (found - expected).to_cols_array().iter().fold(0.0, |worst, entry| worst.max(entry.abs()))
}

fn mat4(rotation: DMat3, translation: DVec3) -> DMat4 {
    let mut out = DMat4::from_mat3(rotation);
    out.w_axis = translation.extend(1.0);
    out
}

fn assert_camera_pose(frame: &RgbdFrame, row: &Value) {
    assert_eq!(frame.depth.stamp_ns, row["stamp_ns"].as_u64().unwrap());
    let pose = frame.pose.unwrap();
    let worst = difference(pose.map_from_base.then(pose.base_from_camera), row);
    assert!(worst < POSE_TOLERANCE, "the pose is off by {worst}");
}

#[test]
fn kitchen_has_the_reference_readers_figures() {
    let Some(path) = data_dir("rgbd/kitchen.mcap") else { return };
    let reader = LogReader::mcap(&path, &Config::default()).unwrap();
    assert_eq!(reader.frame_count_hint(), Some(100));
    let (frames, report) = read_all(reader).unwrap();
    let expected = reference("kitchen");
    assert_eq!(frames.len(), 100);
    assert_eq!(report.depth_images, 100);
    assert!(report.skipped.is_empty(), "{:?}", report.skipped);
    assert_eq!(report.notes.len(), 1, "{:?}", report.notes);
    assert!(
        report.notes[0].contains("/camera/camera/aligned_depth_to_color/image_raw"),
        "{:?}",
        report.notes
    );
    for (at, frame) in frames.iter().enumerate() {
        assert_eq!(frame.index, at as u64);
        assert_depth(frame, &expected["depth"][at]);
        assert_color(frame, &expected["color"][at]);
        assert_intrinsics(frame, &expected["intrinsics"]);
        assert_camera_pose(frame, &expected["transforms"][at]);
        assert_eq!(frame.color_from_depth, Some(Rigid::IDENTITY));
    }
}

#[test]
fn the_pose_comparison_can_fail() {
    let expected = reference("kitchen");
    assert!(difference(Rigid::IDENTITY, &expected["transforms"][0]) > 0.1);
}

/// groundtruth.txt has seven decimals.
const TUM_TOLERANCE_M: f64 = 1e-6;

/// The poses' source matrices are not quite orthonormal, and the two files' writers made quaternions of
/// them in two ways, up to 2.3e-4 rad apart (measured with scipy).
const TUM_TOLERANCE_RAD: f64 = 3e-4;

fn assert_same_pose(a: Rigid, b: Rigid, what: &str) {
    let apart_m = (a.translation_m - b.translation_m).abs().max_element();
    let apart_rad = a.rotation.angle_between(b.rotation);
    assert!(
        apart_m < TUM_TOLERANCE_M && apart_rad < TUM_TOLERANCE_RAD,
        "{what}: {apart_m} m, {apart_rad} rad"
    );
}

#[test]
fn the_tum_folder_gives_what_the_mcap_file_gives() {
    let (Some(mcap), Some(tum)) = (data_dir("rgbd/kitchen.mcap"), data_dir("rgbd/kitchen-tum")) else {
        return;
    };
    let config = Config::default();
    let mut mcap = LogReader::mcap(&mcap, &config).unwrap();
    let mut tum = TumReader::open(&tum, &config).unwrap();
    assert_eq!(tum.frame_count_hint(), Some(100));
    let expected = reference("kitchen_tum");
    for at in 0..100 {
        let (a, b) = (mcap.next_frame().unwrap().unwrap(), tum.next_frame().unwrap().unwrap());
        assert_depth(&b, &expected["depth"][at]);
        assert!(a.depth.stamp_ns.abs_diff(b.depth.stamp_ns) < 1000);
        assert!(a.depth.samples == b.depth.samples, "samples of frame {at} differ");
        assert_eq!((a.depth.camera, a.index), (b.depth.camera, b.index));
        assert!(
            a.color.as_ref().unwrap().rgb == b.color.as_ref().unwrap().rgb,
            "colours of frame {at} differ"
        );
        assert_camera_pose(&b, &expected["transforms"][at]);
        let (a, b) = (a.pose.unwrap(), b.pose.unwrap());
        let camera = |pose: FramePose| pose.map_from_base.then(pose.base_from_camera);
        assert_same_pose(camera(a), camera(b), &format!("cameras of frame {at}"));
        assert_same_pose(a.map_from_base, b.map_from_base, &format!("bases of frame {at}"));
    }
    assert!(mcap.next_frame().unwrap().is_none() && tum.next_frame().unwrap().is_none());
    assert!(tum.report().skipped.is_empty(), "{:?}", tum.report());
    assert_eq!(tum.report().notes.len(), 1, "{:?}", tum.report());
    assert!(tum.report().notes[0].contains("`base_link`"), "{:?}", tum.report());
}

pub(crate) fn config(name: &str) -> Config {
    Config::read(&Path::new("testdata/config").join(name)).unwrap()
}

#[test]
fn foxglove_protobuf_has_the_reference_readers_figures() {
    let Some(path) = data_dir("rgbd/mcap-derived/redkitchen_foxglove_protobuf_lz4.mcap") else { return };
    let (frames, report) = read_all(LogReader::mcap(&path, &Config::default()).unwrap()).unwrap();
    let expected = reference("redkitchen");
    assert_eq!(frames.len(), 8);
    assert!(report.skipped.is_empty(), "{:?}", report.skipped);
    for (at, frame) in frames.iter().enumerate() {
        assert_depth(frame, &expected["depth"][at]);
        assert_color(frame, &expected["color"][at]);
        assert_intrinsics(frame, &expected["intrinsics"]);
        assert_camera_pose(frame, &expected["transforms"][at]);
        // No base in this tree: it stands upright under the camera.
        let base = frame.pose.unwrap().map_from_base;
        assert!((base.rotation * DVec3::Z).abs_diff_eq(DVec3::Z, 1e-12));
        assert_eq!(base.translation_m.z, 0.0);
    }
    assert!(
        report.notes.iter().any(|note| note.contains("no transform of `base_link`")),
        "{:?}",
        report.notes
    );
}

#[test]
fn the_foxglove_configuration_levels_the_map_as_the_kitchen_file_has_it() {
    let Some(path) = data_dir("rgbd/mcap-derived/redkitchen_foxglove_protobuf_lz4.mcap") else { return };
    let (frames, _) = read_all(LogReader::mcap(&path, &config("redkitchen-foxglove.yaml")).unwrap()).unwrap();
    let kitchen = reference("kitchen");
    assert_eq!(frames.len(), 8);
    for (at, frame) in frames.iter().enumerate() {
        // Every second frame of that file shows the same moment.
        let pose = frame.pose.unwrap();
        let worst =
            difference(pose.map_from_base.then(pose.base_from_camera), &kitchen["transforms"][2 * at]);
        assert!(worst < 1e-4, "frame {at} is off by {worst}");
    }
}

#[test]
fn unaligned_depth_comes_with_the_transform_to_colour() {
    let Some(path) = data_dir("rgbd/mcap-derived/librealsense_d435_unaligned_ros2_cdr.mcap") else { return };
    let reader = LogReader::mcap(&path, &config("realsense-unaligned.yaml")).unwrap();
    assert_eq!(reader.frame_count_hint(), Some(2));
    let (frames, report) = read_all(reader).unwrap();
    let expected = reference("realsense");
    assert_eq!(frames.len(), 2);
    assert!(report.skipped.is_empty(), "{:?}", report.skipped);
    for (at, frame) in frames.iter().enumerate() {
        assert_depth(frame, &expected["depth"][at]);
        assert_color(frame, &expected["color"][0]);
        assert_intrinsics(frame, &expected["intrinsics"]);
        let color_from_depth = frame.color_from_depth.unwrap();
        let worst = difference(color_from_depth, &expected["transforms"][0]);
        assert!(worst < POSE_TOLERANCE, "colour from depth is off by {worst}");
        // The optical axis of colour looks along x of the base; depth is 1.1 m high but for the baseline.
        let pose = frame.pose.unwrap();
        let base_from_color = pose.base_from_camera.then(color_from_depth.inverse());
        assert!((base_from_color.rotation * DVec3::Z).abs_diff_eq(DVec3::X, 1e-12));
        assert!((base_from_color.rotation * DVec3::Y).abs_diff_eq(DVec3::NEG_Z, 1e-12));
        assert!((pose.base_from_camera.translation_m.z - 1.1).abs() < 0.02);
    }
}

#[test]
fn unaligned_depth_without_stated_transforms_has_no_pose_and_no_far_colour() {
    let Some(path) = data_dir("rgbd/mcap-derived/librealsense_d435_unaligned_ros2_cdr.mcap") else { return };
    let (frames, report) = read_all(LogReader::mcap(&path, &Config::default()).unwrap()).unwrap();
    assert_eq!(frames.len(), 2);
    assert!(frames.iter().all(|frame| frame.pose.is_none() && frame.color.is_none()));
    assert_eq!(report.skipped.len(), 1, "{:?}", report.skipped);
    assert_eq!(report.skipped[0].count, 2);
    assert_eq!(
        report.skipped[0].reason,
        "no transform from `map` to `camera_depth_optical_frame`: the frames are not connected"
    );
}

#[test]
fn a_still_pair_is_one_frame_with_a_stated_pose() {
    let Some(path) = data_dir("rgbd/lingbot-depth-raw/0") else { return };
    let config = config("still-pair.yaml");
    let mut still = open(&path, &config).unwrap();
    assert_eq!(still.frame_count_hint(), Some(1));
    let frame = still.next_frame().unwrap().unwrap();
    assert!(still.next_frame().unwrap().is_none());
    // SOURCE.txt there: 640x480, holes 0.005, nothing farther than 7.85 m, floor 1.45 m under the camera.
    let raw = integers(&frame);
    let holes = raw.iter().filter(|&&sample| sample == 0).count();
    assert_eq!(raw.len(), 640 * 480);
    assert!((0.0045..0.0055).contains(&(holes as f64 / raw.len() as f64)), "{holes} holes");
    assert!((7840..7860).contains(raw.iter().max().unwrap()));
    let color = frame.color.as_ref().unwrap();
    assert_eq!((color.rgb.len(), color.camera), (3 * 640 * 480, frame.depth.camera));
    // The centre of the lowest row shows the floor.
    let pose = frame.pose.unwrap();
    let depth_m = f64::from(raw[479 * 640 + 320]) * 0.001;
    let [x, y] = frame.depth.camera.ray(320.0, 479.0).unwrap();
    let in_camera = DVec3::new(x, y, 1.0) * depth_m;
    let in_map = pose.map_from_base.then(pose.base_from_camera).transform_point(in_camera);
    assert!(in_map.z.abs() < 0.02, "the floor is at {} m", in_map.z);
    let unnamed = Config { camera_matrix: [0.0; 9], ..config };
    let error = open(&path, &unnamed).unwrap().next_frame().unwrap_err().to_string();
    assert!(error.contains("`camera_matrix`") && error.contains("fx = 0"), "{error}");
}
