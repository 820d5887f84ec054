//! Real recordings against figures from the reference Python readers
//! (tests/reference/rgbd_recordings.py, stored in testdata/reference).

use glam::{DMat3, DMat4, DVec3};
use limpid::Config;
use limpid::geometry::Rigid;
use limpid::recording::{DepthSamples, McapReader, Recording, RgbdFrame};
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
    assert_eq!([camera.fx, camera.fy, camera.cx, camera.cy], expected);
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
    let reader = McapReader::open(&path, &Config::default()).unwrap();
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
