//! Colour, calibrations, codes and units.

use limpid::message::ros2::{CameraInfo, RegionOfInterest};
use limpid::sensor::Distortion;

use super::world::{TIMES_MS, Take};
use super::{ran, says};
use crate::cli::{fails, limpid};
use crate::read::synthetic::{Recorder, at_ms};
use crate::support::gpu::skipped;

const RANGE: [&str; 2] = ["--method", "range"];

#[test]
fn colour_that_is_patchy_late_or_absent_loses_no_obstacle() {
    if skipped() {
        return;
    }
    let whole = ran(&Take::default().save().path, &RANGE);
    assert!(whole.black() > 60, "{}", whole.black());
    // With the first image, 25 ms after the third, with the fourth; then no more.
    let patchy = Take { color_ms: vec![0, 125, 150], ..Take::default() }.save();
    let auto = ran(&patchy.path, &[]);
    says(
        &auto,
        &[
            "method drm: ",
            "camera: 10 used",
            "camera: 8 of 10 by depth alone",
            "1 x the nearest colour image is up to 30 ms off (`pair_tolerance_s` is 0.02)",
            "2 x the nearest colour image is up to 50 ms off",
        ],
    );
    assert_eq!(ran(&patchy.path, &RANGE).differs_from(&whole), 0);
    assert!(auto.black() >= whole.black() * 9 / 10, "{} of {}", auto.black(), whole.black());
    // A tolerance that takes the late one in.
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("limpid.yaml");
    std::fs::write(&file, "pair_tolerance_s: 0.03\n").unwrap();
    says(&ran(&patchy.path, &["-c", file.to_str().unwrap()]), &["camera: 7 of 10 by depth alone"]);
    // Stated, drm takes frames with colour alone.
    let drm = ran(&patchy.path, &["--method", "drm"]);
    says(&drm, &["camera: refused 8, the first: frame 1: colour image: ", "camera: 2 used"]);
    let late = Take { color_ms: TIMES_MS.map(|ms| ms + 25).to_vec(), ..Take::default() }.save();
    let auto = ran(&late.path, &[]);
    says(&auto, &["method range: no colour among the first frames", "up to 30 ms off", "camera: 10 used"]);
    assert_eq!(auto.differs_from(&whole), 0);
    let none = ran(&Take { color_ms: Vec::new(), ..Take::default() }.save().path, &[]);
    says(&none, &["the recording has no colour of this camera"]);
    assert_eq!(none.differs_from(&whole), 0);
}

#[test]
fn colour_without_a_place_or_a_calibration_loses_no_obstacle() {
    if skipped() {
        return;
    }
    let whole = ran(&Take::default().save().path, &RANGE);
    let apart = Take { color_frame: "cam_rgb_optical", ..Take::default() };
    let auto = ran(&apart.save().path, &[]);
    says(&auto, &["method range: ", "no transform from `cam_optical` to `cam_rgb_optical`"]);
    assert_eq!(auto.differs_from(&whole), 0);
    let error = limpid(&["run", apart.save().path.to_str().unwrap(), "--method", "drm"]);
    fails(&error, 1, &["no transform from `cam_optical` to `cam_rgb_optical`", "method drm needs it"]);
    // Colour in a frame of its own whose calibration never came.
    let mut recorder = Recorder::new();
    let depth_alone = Take { color_ms: Vec::new(), ..Take::default() };
    depth_alone.record(&mut recorder);
    for ms in TIMES_MS {
        let mut color = depth_alone.depth(ms);
        (color.encoding, color.step) = ("rgb8".into(), 3 * color.width);
        color.data = vec![90; (color.step * color.height) as usize];
        color.header.frame_id = "cam_rgb_optical".into();
        recorder.image("/cam/color/image_raw", at_ms(ms), &color);
    }
    let auto = ran(&recorder.save().path, &[]);
    says(&auto, &["method range: ", "no usable calibration came for the colour camera", "camera: 10 used"]);
    assert_eq!(auto.differs_from(&whole), 0);
}

#[test]
fn truth_calibrations_that_say_the_same_make_the_same_map() {
    if skipped() {
        return;
    }
    let plain = Take::default();
    let whole = ran(&plain.save().path, &RANGE);
    let info = plain.info.clone().unwrap();
    let other_k = [150.0, 0.0, 84.0, 0.0, 148.0, 57.0, 0.0, 0.0, 1.0];
    // Pixels of the sensor: two of its own make one of the image's.
    let doubled = |m: f64| 2.0 * m + 0.5;
    let large = CameraInfo {
        width: 320,
        height: 240,
        k: [292.0, 0.0, doubled(79.5), 0.0, 292.0, doubled(59.5), 0.0, 0.0, 1.0],
        p: [292.0, 0.0, doubled(79.5), 0.0, 0.0, 292.0, doubled(59.5), 0.0, 0.0, 0.0, 1.0, 0.0],
        ..info.clone()
    };
    let roi = RegionOfInterest { x_offset: 40, y_offset: 30, height: 120, width: 160, do_rectify: true };
    let region = CameraInfo {
        width: 640,
        height: 480,
        roi,
        k: [146.0, 0.0, 119.5, 0.0, 146.0, 89.5, 0.0, 0.0, 1.0],
        p: [146.0, 0.0, 119.5, 0.0, 0.0, 146.0, 89.5, 0.0, 0.0, 0.0, 1.0, 0.0],
        ..info.clone()
    };
    let cases = [
        ("K = 0", "/cam/depth/image_raw", CameraInfo { k: [0.0; 9], ..info.clone() }),
        (
            "rectified",
            "/cam/depth/image_rect",
            CameraInfo { k: other_k, d: vec![-0.3, 0.09, 0.0, 0.0, 0.0], ..info.clone() },
        ),
        ("D = 0", "/cam/depth/image", CameraInfo { k: other_k, d: Vec::new(), ..info }),
        ("binned", "/cam/depth/image_raw", CameraInfo { binning_x: 2, binning_y: 2, ..large.clone() }),
        ("decimated", "/cam/depth/image_raw", large),
        ("region", "/cam/depth/image_raw", region),
    ];
    for (name, depth_topic, info) in cases {
        let take = Take { depth_topic, info: Some(info), color_ms: Vec::new(), ..Take::default() };
        let got = ran(&take.save().path, &RANGE);
        assert_eq!(got.differs_from(&whole), 0, "{name}: {}", got.said);
    }
}

#[test]
fn a_calibration_that_is_missing_can_be_stated() {
    if skipped() {
        return;
    }
    let whole = ran(&Take::default().save().path, &RANGE);
    let bare = Take { info: None, ..Take::default() }.save();
    let path = bare.path.to_str().unwrap();
    fails(&limpid(&["run", path]), 1, &["holds no calibration", "depth_info_topic", "camera_matrix"]);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("limpid.yaml");
    std::fs::write(&file, "camera_matrix: [146, 0, 79.5, 0, 146, 59.5, 0, 0, 1]\n").unwrap();
    let stated = ran(&bare.path, &["-c", file.to_str().unwrap(), "--method", "range"]);
    assert_eq!(stated.differs_from(&whole), 0);
    // Colour in the same frame shares it.
    says(&ran(&bare.path, &["-c", file.to_str().unwrap()]), &["method drm: ", "camera: 10 used"]);
}

#[test]
fn a_fisheye_lens_sees_what_a_pinhole_sees() {
    if skipped() {
        return;
    }
    let whole = ran(&Take::default().save().path, &RANGE);
    let mut take = Take { color_ms: Vec::new(), ..Take::default() };
    take.camera.distortion = Distortion::Fisheye([0.02, -0.01, 0.004, -0.001]);
    take.info = Some(CameraInfo::new(Default::default(), &take.camera));
    assert_eq!(take.info.as_ref().unwrap().distortion_model, "equidistant");
    let fisheye = ran(&take.save().path, &RANGE);
    // Wider, so more wall; the box is the same.
    assert!(fisheye.black() >= whole.black(), "{} and {}", fisheye.black(), whole.black());
    assert!(fisheye.differs_from(&whole) * 10 < 240 * 240, "{}", fisheye.differs_from(&whole));
    // Taken for a pinhole the wall bends.
    let info = CameraInfo { d: Vec::new(), ..take.info.clone().unwrap() };
    let bent = ran(&Take { info: Some(info), ..take }.save().path, &RANGE);
    assert!(bent.differs_from(&fisheye) > 50, "the control: {}", bent.differs_from(&fisheye));
}

#[test]
fn a_depth_unit_that_is_off_is_told_with_its_key() {
    if skipped() {
        return;
    }
    let whole = ran(&Take::default().save().path, &RANGE);
    assert!(!whole.said.contains("Is its unit another"), "{}", whole.said);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("limpid.yaml");
    let floats = Take { floats: true, ..Take::default() };
    for (take, said) in [
        (Take { per_metre: 10_000.0, ..Take::default() }, "depth_unit_m: 0.0001 "),
        (floats.clone(), "float_depth_unit_m: 0.001 "),
        (Take { per_metre: 1e4, ..floats }, "float_depth_unit_m: 0.0001 "),
        (Take { per_metre: 10.0, ..Take::default() }, "depth_unit_m: 0.1 "),
    ] {
        let saved = Take { color_ms: Vec::new(), ..take }.save();
        let off = ran(&saved.path, &[]);
        says(&off, &[said]);
        std::fs::write(&file, said).unwrap();
        let mended = ran(&saved.path, &["-c", file.to_str().unwrap()]);
        assert!(!mended.said.contains("Is its unit another"), "{}", mended.said);
        // Tenths of a metre are too coarse for the same map.
        if !said.contains("0.1 ") {
            assert!(mended.differs_from(&whole) < 30, "{said}: {}", mended.differs_from(&whole));
        }
    }
    let metres = Take { floats: true, per_metre: 1.0, ..Take::default() };
    assert!(!ran(&metres.save().path, &[]).said.contains("Is its unit another"));
}
