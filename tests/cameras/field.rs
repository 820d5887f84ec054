//! Recordings in the shape of public bug reports.

use std::path::PathBuf;

use super::{Ran, ran, says};
use crate::cli::{fails, limpid};
use crate::support::data_dir;
use crate::support::gpu::skipped;

const RANGE: [&str; 2] = ["--method", "range"];

fn case(name: &str) -> Option<PathBuf> {
    data_dir(&format!("field/{name}/in.mcap")).filter(|_| !skipped())
}

/// Maps of a case and of the recording that it is a change of.
fn with_reference(name: &str, more: &[&str]) -> Option<[Ran; 2]> {
    let (case, reference) = (case(name)?, case("reference")?);
    Some([ran(&case, more), ran(&reference, more)])
}

#[test]
fn calibrations_and_codes_make_the_map_of_the_reference() {
    for name in ["binning-2x2", "k-zero-p-valid", "rectified-k-ne-p", "compresseddepth-rvl"] {
        for method in [&RANGE[..], &[]] {
            let Some([got, reference]) = with_reference(name, method) else { return };
            assert_eq!(got.differs_from(&reference), 0, "{name}: {}", got.said);
        }
    }
}

#[test]
fn patchy_colour_loses_no_obstacle() {
    let Some(case) = case("colour-and-depth-lossy") else { return };
    let (auto, range) = (ran(&case, &[]), ran(&case, &RANGE));
    says(&auto, &["12 used", "7 of 12 by depth alone"]);
    says(&range, &["238 occupied"]);
    assert!(auto.black() * 10 >= range.black() * 9, "{} of {}", auto.black(), range.black());
}

#[test]
fn colour_outside_the_transforms_is_done_without() {
    let Some([got, reference]) = with_reference("colour-frame-not-in-tf", &[]) else { return };
    says(&got, &["method range: ", "camera_color_optical_frame2", "not connected"]);
    let Some(range) = case("reference").map(|reference| ran(&reference, &RANGE)) else { return };
    assert_eq!(got.differs_from(&range), 0);
    assert!(reference.black() > 0);
}

#[test]
fn a_unit_of_a_tenth_is_told() {
    let Some(case) = case("depth-unit-tenth") else { return };
    for method in [&RANGE[..], &[]] {
        says(&ran(&case, method), &["depth_unit_m: 0.0001 "]);
    }
}

#[test]
fn of_two_depth_cameras_the_other_is_named() {
    let Some([got, reference]) = with_reference("two-depth-cameras", &RANGE) else { return };
    says(&got, &["depth /front/depth/image_raw ", "colour /front/color/image_raw ", "/back/depth/image_raw"]);
    assert_eq!(got.differs_from(&reference), 0);
}

#[test]
fn the_cameras_own_cloud_is_left_out() {
    let Some([got, reference]) = with_reference("rgbd-and-its-xyzrgb-cloud", &RANGE) else { return };
    says(&got, &["/camera/camera/depth/color/points is left out"]);
    assert_eq!(got.differs_from(&reference), 0);
}

#[test]
fn a_tum_folder_without_calibration_is_told_what_it_lacks() {
    let Some(folder) = data_dir("field/tum-without-camera-yaml/f").filter(|_| !skipped()) else { return };
    let run = |more: &[&str]| limpid(&[&["run", folder.to_str().unwrap()], more].concat());
    fails(&run(&[]), 1, &["camera.yaml", "image_width: 640", "camera_matrix: {", "depth_scale_m: 0.0002"]);
    let settings = tempfile::tempdir().unwrap();
    let file = settings.path().join("limpid.yaml");
    std::fs::write(&file, "camera_matrix: [110, 0, 79.5, 0, 110, 59.5, 0, 0, 1]\ndepth_unit_m: 0.0002\n")
        .unwrap();
    let text = crate::cli::succeeds(&run(&["-c", file.to_str().unwrap()]));
    assert!(text.contains("camera: 6 used"), "{text}");
}
