//! TUM folders made by the tests themselves.

use std::path::Path;

use image::{DynamicImage, ImageBuffer, Luma, Rgb};
use limpid::Config;
use limpid::config::StaticTransform;
use limpid::input::TumReader;
use limpid::sensor::DepthSamples;

use super::{noted, read_all, skipped};

const CAMERA: &str = "image_width: 4
image_height: 3
camera_name: anything
distortion_model: plumb_bob
camera_matrix: {rows: 3, cols: 3, data: [5.0, 0, 2.0, 0, 6.0, 1.5, 0, 0, 1]}
distortion_coefficients: {rows: 1, cols: 5, data: [0.1, 0, 0, 0, 0]}
depth_scale_m: 0.0002
";

fn write(folder: &Path, name: &str, text: &str) {
    std::fs::write(folder.join(name), text).unwrap();
}

fn write_depth(folder: &Path, name: &str, [width, height]: [u32; 2], value: u16) {
    let image = ImageBuffer::from_pixel(width, height, Luma([value]));
    DynamicImage::ImageLuma16(image).save(folder.join(name)).unwrap();
}

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write(at, "camera.yaml", CAMERA);
    write(
        at,
        "depth.txt",
        "# comment\n1.00 a.png\n1.10 b.png\n1.05 a.png\n1.20 absent.png\n1.30 large.png\n\n1.40 a.png x\n1.50 a.png\n",
    );
    write(at, "rgb.txt", "1.095 rgb.png\n1.49 absent.png\n");
    write(
        at,
        "groundtruth.txt",
        "1.0 0 0 1 -0.5 0.5 -0.5 0.5\n1.2 2 0 1 -0.5 0.5 -0.5 0.5\nx 0 0 0 0 0 0 1\n1.3 0 0 0 0 0 0 0\n",
    );
    write_depth(at, "a.png", [4, 3], 1000);
    write_depth(at, "b.png", [4, 3], 2000);
    write_depth(at, "large.png", [5, 3], 2000);
    DynamicImage::ImageRgb8(ImageBuffer::from_pixel(4, 3, Rgb([1, 2, 3]))).save(at.join("rgb.png")).unwrap();
    folder
}

#[test]
fn a_folder_with_faults_gives_its_good_frames() {
    let folder = folder();
    let (frames, report) = read_all(TumReader::open(folder.path(), &Config::default()).unwrap()).unwrap();
    let indices: Vec<u64> = frames.iter().map(|frame| frame.index).collect();
    assert_eq!(indices, [0, 1, 5]);
    assert_eq!(report.depth_images, 6);
    let frame = &frames[1];
    assert_eq!(frame.depth.stamp_ns, 1_100_000_000);
    assert_eq!(frame.depth.samples, DepthSamples::Integer { raw: vec![2000; 12], unit_m: 0.0002 });
    assert_eq!((frame.depth.camera.fy, frame.depth.camera.distortion.coefficients()[0]), (6.0, 0.1));
    assert_eq!(frame.color.as_ref().unwrap().rgb, [1, 2, 3].repeat(12));
    assert!(frames[0].color.is_none() && frames[2].color.is_none());
    // Half way between the two poses; the base stands under the camera and faces along the optical axis.
    let pose = frame.pose.unwrap();
    assert!(pose.map_from_base.translation_m.abs_diff_eq(glam::DVec3::new(1.0, 0.0, 0.0), 1e-9), "{pose:?}");
    assert!(pose.map_from_base.rotation.angle_between(glam::DQuat::IDENTITY) < 1e-6, "{pose:?}");
    assert!(frames[2].pose.is_none());
    for (part, count) in [
        ("not after the previous", 1),
        ("absent.png", 2),
        ("large.png: is 5x3, but camera.yaml is for 4x3", 1),
        ("does not have the fields", 3),
        ("past the newest transform", 1),
    ] {
        assert_eq!(skipped(&report, part), count, "{part}: {:?}", report.skipped);
    }
}

#[test]
fn poses_that_come_more_rarely_than_frames_last_to_the_end() {
    let folder = folder();
    // Twenty seconds, twice the window of the transform buffer: 30 frames and 10 poses a second along x = t.
    let depth: String = (0..600_u32).map(|i| format!("{:.6} a.png\n", 1.0 + f64::from(i) / 30.0)).collect();
    let poses: String = (0..=201_u32)
        .map(|i| f64::from(i) / 10.0)
        .map(|t| format!("{:.6} {t} 0 1 -0.5 0.5 -0.5 0.5\n", 1.0 + t))
        .collect();
    write(folder.path(), "depth.txt", &depth);
    write(folder.path(), "groundtruth.txt", &poses);
    let (frames, report) = read_all(TumReader::open(folder.path(), &Config::default()).unwrap()).unwrap();
    assert_eq!(frames.len(), 600);
    for (i, frame) in (0_u32..).zip(&frames) {
        let pose = frame.pose.unwrap_or_else(|| panic!("frame {i}: {:?}", report.skipped));
        let off_m = pose.map_from_base.translation_m.x - f64::from(i) / 30.0;
        assert!(off_m.abs() < 1e-5, "frame {i} lies off by {off_m} m");
    }
}

#[test]
fn a_stated_base_takes_the_place_of_the_derived_one() {
    let stated = StaticTransform {
        parent: "base_link".into(),
        child: "camera".into(),
        translation_m: [0.25, 0.0, 1.0],
        rotation_xyzw: [-0.5, 0.5, -0.5, 0.5],
    };
    let config = Config { static_transforms: vec![stated], ..Config::default() };
    let folder = folder();
    let (frames, report) = read_all(TumReader::open(folder.path(), &config).unwrap()).unwrap();
    let base_m = frames[1].pose.unwrap().map_from_base.translation_m;
    assert!(base_m.abs_diff_eq(glam::DVec3::new(0.75, 0.0, 0.0), 1e-9), "{base_m}");
    assert!(!noted(&report, "the base is taken to stand"), "{:?}", report.notes);
}

#[test]
fn lists_that_may_be_absent_are_noted_and_others_are_errors() {
    let folder = folder();
    std::fs::remove_file(folder.path().join("rgb.txt")).unwrap();
    std::fs::remove_file(folder.path().join("groundtruth.txt")).unwrap();
    let (frames, report) = read_all(TumReader::open(folder.path(), &Config::default()).unwrap()).unwrap();
    assert!(frames.len() == 3 && frames.iter().all(|frame| frame.color.is_none() && frame.pose.is_none()));
    assert!(noted(&report, "no rgb.txt") && noted(&report, "no groundtruth.txt"), "{:?}", report.notes);
    std::fs::remove_file(folder.path().join("camera.yaml")).unwrap();
    let error = TumReader::open(folder.path(), &Config::default()).err().unwrap().to_string();
    assert!(error.contains("camera.yaml"), "{error}");
}

#[test]
fn bad_calibrations_name_file_and_fault() {
    let folder = folder();
    for (from, to, part) in [
        ("[5.0, 0,", "[0.0, 0,", "fx = 0"),
        ("[5.0, 0,", "[.nan, 0,", "fx = NaN"),
        ("0, 0, 1]}", "0]}", "7 numbers in place of 9"),
        ("0.0002", "-1", "depth_scale_m = -1"),
        ("plumb_bob", "fisheye", "fisheye"),
        ("image_width: 4", "image_width: 0", "0x3"),
        ("image_width: 4\n", "", "image_width"),
    ] {
        write(folder.path(), "camera.yaml", &CAMERA.replacen(from, to, 1));
        let error = TumReader::open(folder.path(), &Config::default()).err().unwrap().to_string();
        assert!(error.contains("camera.yaml") && error.contains(part), "{part}: {error}");
    }
}
