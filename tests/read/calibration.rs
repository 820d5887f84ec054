//! Calibrations as recordings state them: matrices, lenses, binning and regions. Figures of lenses are OpenCV's.

use limpid::Config;
use limpid::message::ros2::{CameraInfo, RegionOfInterest};
use limpid::sensor::{CameraModel, Distortion};

use super::synthetic::{DEPTH_INFO, FRAME, Recorder, SIZE, at_ms, camera_info, depth_image};
use super::{noted, read_mcap, skipped};

/// What `cv2.fisheye.projectPoints` and `cv2.projectPoints` (OpenCV 5.0) give for K = [285.7, 0, 321.3; 0, 286.1, 239.2].
const FISHEYE: ([f64; 4], [[f64; 4]; 5]) = (
    [-0.012, 0.034, -0.018, 0.0031],
    [
        [0.0, 0.0, 321.3, 239.2],
        [0.3, -0.2, 403.4805668296721, 184.336249749226],
        [-1.1, 0.7, 99.32889085457666, 380.6521081508064],
        [1.9, 1.4, 593.6376996942804, 440.15083587043284],
        [-3.0, 0.5, -36.844742608586614, 298.97436171993735],
    ],
);
const PLUMB_BOB: ([f64; 5], [[f64; 4]; 4]) = (
    [0.05, -0.12, 0.0008, -0.0011, 0.03],
    [
        [0.0, 0.0, 321.3, 239.2],
        [0.3, -0.2, 407.27409336610003, 181.80617078979998],
        [-0.5, 0.4, 177.73037455450003, 354.2071222972],
        [0.7, 0.5, 517.5985571528, 379.945281396],
    ],
);
const RATIONAL: ([f64; 8], [[f64; 4]; 4]) = (
    [0.46, -2.6, 0.0007, -0.0003, 1.5, 0.34, -2.4, 1.42],
    [
        [0.0, 0.0, 321.3, 239.2],
        [0.3, -0.2, 408.01473808873595, 181.32783330506976],
        [-0.5, 0.4, 174.67827360651003, 356.71556411958],
        [0.7, 0.5, 525.8449099966717, 385.70162936394763],
    ],
);

#[test]
fn truth_lenses_are_those_of_opencv() {
    let model = |name: &str, d: &[f64]| Distortion::from_ros(name, d).unwrap();
    let cases = [
        (model("equidistant", &FISHEYE.0), FISHEYE.1.to_vec()),
        (model("fisheye", &FISHEYE.0), FISHEYE.1.to_vec()),
        (model("Kannala-Brandt", &FISHEYE.0), FISHEYE.1.to_vec()),
        (model("plumb_bob", &PLUMB_BOB.0), PLUMB_BOB.1.to_vec()),
        (model("", &PLUMB_BOB.0), PLUMB_BOB.1.to_vec()),
        (model("rational_polynomial", &RATIONAL.0), RATIONAL.1.to_vec()),
        // The number of coefficients tells the polynomial, as in OpenCV.
        (model("plumb_bob", &RATIONAL.0), RATIONAL.1.to_vec()),
        (model("rational_polynomial", &PLUMB_BOB.0), PLUMB_BOB.1.to_vec()),
    ];
    for (distortion, points) in cases {
        let camera =
            CameraModel { width: 640, height: 480, fx: 285.7, fy: 286.1, cx: 321.3, cy: 239.2, distortion };
        for [x, y, u, v] in points {
            let [dx, dy] = distortion.distort([x, y]);
            let got = [dx * camera.fx + camera.cx, dy * camera.fy + camera.cy];
            assert!((got[0] - u).abs() < 1e-7 && (got[1] - v).abs() < 1e-7, "{distortion:?}: {got:?}");
            let ray = camera.ray(u, v).unwrap();
            assert!((ray[0] - x).abs() < 1e-7 && (ray[1] - y).abs() < 1e-7, "{distortion:?}: {ray:?}");
        }
    }
}

#[test]
fn lenses_that_are_unknown_are_refused_by_name() {
    for (model, d) in [
        ("fisheye62", &[0.1; 6][..]),
        ("equidistant", &[0.1; 5]),
        ("plumb_bob", &[0.1; 3]),
        ("plumb_bob", &[0.1; 9]),
        ("plumb_bob", &[f64::NAN; 5]),
    ] {
        let error = Distortion::from_ros(model, d).unwrap_err().to_string();
        assert!(error.contains(model) || error.contains("finite"), "{error}");
    }
    // As image_geometry has it, zeros are no lens whatever its name.
    for model in ["equidistant", "fisheye62", ""] {
        assert_eq!(Distortion::from_ros(model, &[0.0; 4]).unwrap(), Distortion::None);
    }
}

#[test]
fn a_fisheye_pixel_past_a_right_angle_has_no_ray() {
    // r = 100 theta: a right angle lies 157 pixels from the centre.
    let distortion = Distortion::Fisheye([0.0, 0.0, 0.0, 0.0]);
    let camera =
        CameraModel { width: 400, height: 400, fx: 100.0, fy: 100.0, cx: 200.0, cy: 200.0, distortion };
    let [x, y] = camera.ray(200.0 + 78.539_816, 200.0).unwrap();
    assert!((x - 1.0).abs() < 1e-6 && y == 0.0, "45 degrees");
    assert!(camera.ray(350.0, 200.0).is_some());
    assert_eq!(camera.ray(360.0, 200.0), None);
    assert_eq!(camera.ray(0.0, 0.0), None);
    // A lens whose distance stops growing with the angle: 0.3 (1 - 0.9 / 3 ...) is reached, 0.9 is not.
    let folding = Distortion::Fisheye([-1.0, 0.0, 0.0, 0.0]);
    assert!(folding.undistort([0.3, 0.0]).is_some());
    assert_eq!(folding.undistort([0.9, 0.0]), None);
}

/// The camera of a depth image of SIZE on `topic` by `info`, and the notes of its report.
fn camera(topic: &str, info: &CameraInfo) -> (Option<CameraModel>, limpid::input::ReadReport) {
    let mut recorder = Recorder::new();
    let beside = format!("{}/camera_info", topic.rsplit_once('/').unwrap().0);
    recorder.info(&beside, at_ms(0), info);
    recorder.image(topic, at_ms(0), &depth_image(at_ms(0), 700));
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    (frames.first().map(|frame| frame.depth.camera), report)
}

const P: [f64; 12] = [7.0, 0.0, 1.75, 0.0, 0.0, 8.0, 1.25, 0.0, 0.0, 0.0, 1.0, 0.0];

fn model([fx, fy, cx, cy]: [f64; 4], distortion: Distortion) -> Option<CameraModel> {
    let [width, height] = SIZE;
    Some(CameraModel { width, height, fx, fy, cx, cy, distortion })
}

#[test]
fn truth_raw_images_have_k_and_d_and_rectified_ones_p() {
    let lens = vec![0.1, 0.02, 0.0, 0.0, 0.0];
    let info = CameraInfo { p: P, d: lens.clone(), ..camera_info(at_ms(0), FRAME) };
    let k = [5.0, 6.0, 2.0, 1.5];
    let raw = model(k, Distortion::PlumbBob([0.1, 0.02, 0.0, 0.0, 0.0]));
    let by_p = model([7.0, 8.0, 1.75, 1.25], Distortion::None);
    for topic in ["/cam/depth/image_raw", "/cam/depth/image", "/cam/direct/depth"] {
        assert_eq!(camera(topic, &info).0, raw, "{topic}");
    }
    for topic in [
        "/cam/depth/image_rect",
        "/cam/depth/image_rect_raw",
        "/depth/Image_Rectified",
        "/c/image_rect/depth",
    ] {
        let (got, report) = camera(topic, &info);
        assert_eq!(got, by_p, "{topic}");
        assert!(noted(&report, "P without D is taken"), "{:?}", report.notes);
    }
    // Neither the name nor K, only P.
    let (got, report) = camera("/cam/depth/image_raw", &CameraInfo { k: [0.0; 9], ..info.clone() });
    assert_eq!(got, by_p);
    assert!(noted(&report, "fx = 0"), "{:?}", report.notes);
    // Without a lens images are rectified.
    let (got, report) = camera("/cam/depth/image_raw", &CameraInfo { d: vec![0.0; 5], ..info.clone() });
    assert_eq!(got, by_p);
    assert!(noted(&report, "its D is zero"), "{:?}", report.notes);
    // K alone, as many drivers give it.
    let (got, report) = camera("/cam/depth/image_rect", &CameraInfo { p: [0.0; 12], ..info.clone() });
    assert_eq!(got, model(k, Distortion::None));
    assert!(noted(&report, "P is empty"), "{:?}", report.notes);
    // The same in both: nothing to tell.
    let alike = CameraInfo::new(info.header.clone(), &model(k, Distortion::None).unwrap());
    let (got, report) = camera("/cam/depth/image_rect", &alike);
    assert_eq!(got, model(k, Distortion::None));
    assert!(!noted(&report, "calibration `"), "{:?}", report.notes);
}

#[test]
fn truth_binning_region_and_decimation_scale_the_camera() {
    let half = model([2.5, 3.0, 0.75, 0.5], Distortion::None);
    let large = |width, height| CameraInfo { width, height, ..camera_info(at_ms(0), FRAME) };
    let topic = "/cam/depth/image_raw";
    // Two pixels in one: their centre, 2.0, lies at (2.0 + 0.5) / 2 - 0.5.
    let binned = CameraInfo { binning_x: 2, binning_y: 2, ..large(8, 6) };
    assert_eq!(camera(topic, &binned).0, half);
    // The whole sensor stated as a region.
    let roi = RegionOfInterest { width: 8, height: 6, ..RegionOfInterest::default() };
    assert_eq!(camera(topic, &CameraInfo { roi, ..binned.clone() }).0, half);
    let (got, report) = camera(topic, &large(8, 6));
    assert_eq!(got, half);
    assert!(noted(&report, "every second pixel"), "{:?}", report.notes);
    let (got, report) = camera(topic, &large(12, 9));
    assert_eq!(got.map(|camera| camera.fx), Some(5.0 / 3.0));
    assert!(noted(&report, "every third pixel"), "{:?}", report.notes);
    // A region of 4x3 at (3, 1), of raw and of rectified images.
    let roi = RegionOfInterest { x_offset: 3, y_offset: 1, height: 3, width: 4, do_rectify: true };
    let region = CameraInfo { roi, p: P, ..large(20, 10) };
    assert_eq!(camera("/c/depth/image_rect", &region).0, model([7.0, 8.0, -1.25, 0.25], Distortion::None));
    let k_only = CameraInfo { p: [0.0; 12], ..region.clone() };
    assert_eq!(camera(topic, &k_only).0, model([5.0, 6.0, -1.0, 0.5], Distortion::None));
    // A region of 8x6, binned.
    let roi = RegionOfInterest { height: 6, width: 8, ..roi };
    let both = CameraInfo { roi, binning_x: 2, binning_y: 2, ..k_only };
    assert_eq!(camera(topic, &both).0, model([2.5, 3.0, -0.75, 0.0], Distortion::None));
    // Binning that is stated and already in the size.
    let already = CameraInfo { binning_x: 2, binning_y: 2, ..large(4, 3) };
    let (got, report) = camera(topic, &already);
    assert_eq!(got, model([5.0, 6.0, 2.0, 1.5], Distortion::None));
    assert!(noted(&report, "taken as it is"), "{:?}", report.notes);
}

#[test]
fn a_calibration_without_a_size_is_for_the_images() {
    let unsized_info = CameraInfo { width: 0, height: 0, ..camera_info(at_ms(0), FRAME) };
    let (got, report) = camera("/cam/depth/image_raw", &unsized_info);
    assert_eq!(got, model([5.0, 6.0, 2.0, 1.5], Distortion::None));
    assert!(noted(&report, "states no size: taken to be for 4x3"), "{:?}", report.notes);
    let binned = CameraInfo { binning_x: 2, binning_y: 2, ..unsized_info.clone() };
    assert_eq!(camera("/cam/depth/image_raw", &binned).0, model([2.5, 3.0, 0.75, 0.5], Distortion::None));
    let half = CameraInfo { width: 4, ..unsized_info };
    let mut recorder = Recorder::new();
    recorder.info(DEPTH_INFO, at_ms(0), &half);
    recorder.image(super::synthetic::DEPTH, at_ms(0), &depth_image(at_ms(0), 7));
    let error = read_mcap(&recorder.save(), &Config::default()).unwrap_err().to_string();
    assert!(error.contains("image size is 4x0"), "{error}");
}

#[test]
fn sizes_that_do_not_fit_are_refused_with_both() {
    let large = |width, height| CameraInfo { width, height, ..camera_info(at_ms(0), FRAME) };
    let topic = "/cam/depth/image_raw";
    for (info, part) in [
        (large(2, 1), "is for 2x1, but it is 4x3"),
        (large(8, 3), "is for 8x3, but it is 4x3"),
        (large(9, 5), "is for 9x5, but it is 4x3"),
        (
            CameraInfo { binning_x: 3, binning_y: 3, ..large(8, 6) },
            "is for 8x6 (2x2 by its binning and region)",
        ),
        (CameraInfo { binning_x: u32::MAX, binning_y: u32::MAX, ..large(8, 6) }, "(0x0 by its binning"),
        (CameraInfo { distortion_model: "fisheye62".into(), d: vec![0.1; 6], ..large(4, 3) }, "`fisheye62`"),
    ] {
        let (got, report) = camera(topic, &info);
        assert_eq!((got, skipped(&report, part)), (None, 1), "{part}: {:?}", report.skipped);
    }
}

#[test]
fn the_reason_of_a_refused_calibration_is_told_where_nothing_else_is_usable() {
    let mut recorder = Recorder::new();
    let info = CameraInfo { k: [0.0; 9], ..camera_info(at_ms(0), FRAME) };
    recorder.info(DEPTH_INFO, at_ms(0), &info);
    recorder.image(super::synthetic::DEPTH, at_ms(0), &depth_image(at_ms(0), 7));
    let error = read_mcap(&recorder.save(), &Config::default()).unwrap_err().to_string();
    for part in ["no usable calibration", DEPTH_INFO, "K: fx = 0", "P: is empty", "camera_matrix"] {
        assert!(error.contains(part), "{part}: {error}");
    }
}

#[test]
fn a_stated_calibration_takes_the_place_of_a_missing_one() {
    let mut recorder = Recorder::new();
    recorder.image(super::synthetic::DEPTH, at_ms(0), &depth_image(at_ms(0), 7));
    let stated = "camera_matrix: [5.0, 0, 2.0, 0, 6.0, 1.5, 0, 0, 1]\ndistortion: [0.1, 0.0, 0, 0]\n";
    let config = |more: &str| Config::from_yaml(&format!("{stated}{more}"));
    let saved = recorder.save();
    let (frames, _) = read_mcap(&saved, &config("").unwrap()).unwrap();
    let lens = Distortion::PlumbBob([0.1, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(Some(frames[0].depth.camera), model([5.0, 6.0, 2.0, 1.5], lens));
    let (frames, _) = read_mcap(&saved, &config("distortion_model: equidistant").unwrap()).unwrap();
    assert_eq!(frames[0].depth.camera.distortion, Distortion::Fisheye([0.1, 0.0, 0.0, 0.0]));
    let error = config("distortion_model: pinhole").unwrap_err().to_string();
    assert!(error.contains("`distortion`") && error.contains("`pinhole`"), "{error}");
    let error = Config::from_yaml("distortion: [0.1, 0, 0, 0]").unwrap_err().to_string();
    assert!(error.contains("`distortion`") && error.contains("camera_matrix"), "{error}");
}
