//! What belongs to a depth image, and images that cannot be used.

use limpid::Config;
use limpid::base::Rigid;
use limpid::input::LogReader;
use limpid::sensor::DepthSamples;

use super::synthetic::{
    COLOR, COLOR_INFO, DEPTH, DEPTH_INFO, FRAME, Recorder, SIZE, at_ms, camera_info, depth_image, raw_image,
};
use super::{noted, read_mcap, skipped};

#[test]
fn the_nearest_colour_wins_and_far_ones_do_not_count() {
    let mut recorder = Recorder::new();
    for (ms, value) in [(0, 1), (85, 2), (92, 3), (115, 4), (400, 5)] {
        recorder.color(at_ms(ms), value);
    }
    for ms in [100, 300] {
        recorder.depth(at_ms(ms), 7);
    }
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    assert_eq!(frames.len(), 2);
    let color = frames[0].color.as_ref().unwrap();
    assert_eq!((color.stamp_ns, color.rgb[0]), (at_ms(92), 3));
    assert_eq!(frames[0].color_from_depth, Some(Rigid::IDENTITY));
    assert_eq!((&frames[1].color, &frames[1].color_from_depth), (&None, &None));
    assert_eq!(skipped(&report, "no transform from `map` to `cam_optical`"), 2);
    assert!(frames.iter().all(|frame| frame.pose.is_none()));
}

#[test]
fn colour_that_comes_later_in_the_file_is_waited_for() {
    let mut recorder = Recorder::new();
    for ms in [0, 33, 66] {
        recorder.depth(at_ms(ms), 7);
    }
    for (ms, value) in [(1, 1), (34, 2), (67, 3)] {
        recorder.color(at_ms(ms), value);
    }
    let (frames, _) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    let values: Vec<u8> = frames.iter().map(|frame| frame.color.as_ref().unwrap().rgb[0]).collect();
    assert_eq!(values, [1, 2, 3]);
}

#[test]
fn depth_images_out_of_order_come_in_order_where_they_still_wait() {
    let mut recorder = Recorder::new();
    for ms in [33, 0, 66] {
        recorder.depth(at_ms(ms), 7);
    }
    recorder.color(at_ms(0), 1);
    recorder.color(at_ms(66), 1);
    let (frames, _) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    let order: Vec<_> = frames.iter().map(|frame| (frame.depth.stamp_ns, frame.index)).collect();
    assert_eq!(order, [(at_ms(0), 1), (at_ms(33), 0), (at_ms(66), 2)]);
}

#[test]
fn images_without_colour_and_tf_are_not_held_back() {
    let mut recorder = Recorder::new();
    recorder.depth(at_ms(0), 700);
    recorder.depth(at_ms(33), 800);
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    assert_eq!(frames.len(), 2);
    let samples = vec![800; (SIZE[0] * SIZE[1]) as usize];
    assert_eq!(frames[1].depth.samples, DepthSamples::Integer { raw: samples, unit_m: 0.001 });
    assert!(noted(&report, "colour none"), "{:?}", report.notes);
}

#[test]
fn stamps_that_do_not_go_on_are_skipped() {
    let mut recorder = Recorder::new();
    for ms in [0, 33, 33, 10, 66] {
        recorder.depth(at_ms(ms), 7);
    }
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    let indices: Vec<u64> = frames.iter().map(|frame| frame.index).collect();
    assert_eq!(indices, [0, 1, 4]);
    assert_eq!(skipped(&report, "not after the previous"), 2);
    assert_eq!(report.depth_images, 5);
}

#[test]
fn a_looped_recording_goes_on() {
    let mut recorder = Recorder::new();
    for ms in [5000, 5033, 0, 33] {
        recorder.color(at_ms(ms), 9);
        recorder.depth(at_ms(ms), 7);
    }
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    let stamps: Vec<u64> = frames.iter().map(|frame| frame.depth.stamp_ns).collect();
    assert_eq!(stamps, [at_ms(5000), at_ms(5033), at_ms(0), at_ms(33)]);
    assert!(frames.iter().all(|frame| frame.color.is_some()));
    assert!(noted(&report, "jumped back"), "{:?}", report.notes);
}

#[test]
fn bad_images_are_counted_with_their_reason() {
    let mut recorder = Recorder::new();
    recorder.depth(at_ms(0), 7);
    recorder.image(DEPTH, at_ms(10), &raw_image(at_ms(10), "64FC1", 32, vec![0; 96]));
    recorder.image(DEPTH, at_ms(20), &raw_image(at_ms(20), "16UC1", 8, vec![0; 23]));
    recorder.image(DEPTH, at_ms(30), &raw_image(at_ms(30), "16UC1", 7, vec![0; 24]));
    let mut large = depth_image(at_ms(40), 7);
    large.height = 2;
    recorder.image(DEPTH, at_ms(40), &large);
    recorder.bytes(DEPTH, "sensor_msgs/msg/Image", "cdr", at_ms(50), &[0, 1, 0, 0, 1, 2, 3]);
    recorder.depth(at_ms(60), 8);
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    let indices: Vec<u64> = frames.iter().map(|frame| frame.index).collect();
    assert_eq!(indices, [0, 6]);
    for part in [
        "encoding `64FC1` is not supported; 16UC1, mono16 and 32FC1 are",
        "does not fit its payload of 23 bytes",
        "step is 7 bytes, but 4 pixels take 8",
        "calibration is for 4x3, but it is 4x2",
        "sensor_msgs/Image:",
    ] {
        assert_eq!(skipped(&report, part), 1, "{part}: {:?}", report.skipped);
    }
    assert!(report.skipped.iter().all(|skip| skip.source == DEPTH), "{:?}", report.skipped);
}

#[test]
fn images_without_stamps_are_told() {
    let mut recorder = Recorder::new();
    recorder.info(DEPTH_INFO, 0, &camera_info(0, FRAME));
    for value in [7, 8] {
        recorder.image(DEPTH, 0, &depth_image(0, value));
    }
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    assert_eq!((frames.len(), skipped(&report, "its stamp is 0")), (1, 1), "{:?}", report.skipped);
}

#[test]
fn bad_colour_leaves_depth_alone() {
    let mut recorder = Recorder::new();
    recorder.image(COLOR, at_ms(0), &raw_image(at_ms(0), "i420", 4, vec![0; 18]));
    recorder.depth(at_ms(0), 7);
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    assert_eq!(frames.len(), 1);
    assert!(frames[0].color.is_none());
    assert_eq!(skipped(&report, "encoding `i420` is not supported; rgb8"), 1, "{:?}", report.skipped);
}

#[test]
fn bad_intrinsics_are_counted_and_good_ones_wait() {
    let mut recorder = Recorder::new();
    let mut info = camera_info(at_ms(0), "cam_optical");
    info.k[0] = 0.0;
    recorder.info(DEPTH_INFO, at_ms(0), &info);
    info.k[0] = f64::NAN;
    recorder.info(DEPTH_INFO, at_ms(0), &info);
    let without =
        |report: &limpid::input::ReadReport| (skipped(report, "fx = 0"), skipped(report, "fx = NaN"));
    recorder.image(DEPTH, at_ms(0), &depth_image(at_ms(0), 7));
    recorder.depth(at_ms(33), 7);
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    assert_eq!(frames.len(), 2);
    assert_eq!(without(&report), (1, 1));
}

#[test]
fn images_that_wait_keep_the_calibration_of_their_size() {
    let mut recorder = Recorder::new();
    recorder.color(at_ms(0), 1);
    // Waits for the next colour image, before which the camera changes its size.
    recorder.depth(at_ms(10), 7);
    let mut info = camera_info(at_ms(20), "cam_optical");
    info.height = 6;
    recorder.info(DEPTH_INFO, at_ms(20), &info);
    let mut large = depth_image(at_ms(30), 7);
    (large.height, large.data) = (6, vec![1; 48]);
    recorder.image(DEPTH, at_ms(30), &large);
    recorder.color(at_ms(40), 2);
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    let heights: Vec<u32> = frames.iter().map(|frame| frame.depth.camera.height).collect();
    assert_eq!(heights, [3, 6], "{report:?}");
}

#[test]
fn a_recording_whose_calibrations_are_all_bad_is_an_error() {
    let mut recorder = Recorder::new();
    let mut info = camera_info(at_ms(0), "cam_optical");
    info.k[4] = f64::INFINITY;
    recorder.info(DEPTH_INFO, at_ms(0), &info);
    recorder.image(DEPTH, at_ms(0), &depth_image(at_ms(0), 7));
    let error = read_mcap(&recorder.save(), &Config::default()).unwrap_err().to_string();
    assert!(error.contains("no usable calibration") && error.contains(DEPTH_INFO), "{error}");
}

#[test]
fn a_recording_without_calibration_topic_is_refused() {
    let mut recorder = Recorder::new();
    recorder.image(DEPTH, at_ms(0), &depth_image(at_ms(0), 7));
    let error = LogReader::mcap(&recorder.save().path, &Config::default()).err().unwrap().to_string();
    assert!(error.contains("no calibration") && error.contains("depth_info_topic"), "{error}");
}

#[test]
fn a_configured_topic_that_is_absent_names_the_nearest() {
    let mut recorder = Recorder::new();
    recorder.depth(at_ms(0), 7);
    recorder.color(at_ms(0), 7);
    let saved = recorder.save();
    let config = Config { depth_topic: "/cam/depth/image".into(), ..Config::default() };
    let error = LogReader::mcap(&saved.path, &config).err().unwrap().to_string();
    assert!(
        error.contains("`depth_topic`") && error.contains("nearest of the right type: /cam/depth/image_raw"),
        "{error}"
    );
    let config = Config { depth_topic: DEPTH_INFO.into(), ..Config::default() };
    let error = LogReader::mcap(&saved.path, &config).err().unwrap().to_string();
    assert!(error.contains("CameraInfo"), "{error}");
}

#[test]
fn confidence_comes_on_the_depth_grid() {
    let mut recorder = Recorder::new();
    recorder.image("/cam/confidence", at_ms(0), &raw_image(at_ms(0), "mono8", 4, vec![51; 12]));
    recorder.depth(at_ms(0), 7);
    recorder.depth(at_ms(500), 7);
    let config = Config { confidence_topic: "/cam/confidence".into(), ..Config::default() };
    let (frames, _) = read_mcap(&recorder.save(), &config).unwrap();
    assert_eq!(frames[0].confidence, Some(vec![0.2; 12]));
    assert_eq!(frames[1].confidence, None);
}

#[test]
fn colour_of_another_frame_needs_a_transform() {
    let recording = |linked: bool| {
        let mut recorder = Recorder::new();
        if linked {
            recorder.transform(
                "/tf_static",
                at_ms(0),
                ["rgb_optical", "cam_optical"],
                [0.05, 0.0, 0.0],
                [0.0, 0.0, 0.0, 1.0],
            );
        }
        let mut color = raw_image(at_ms(0), "rgb8", 12, vec![1; 36]);
        color.header.frame_id = "rgb_optical".into();
        recorder.info(COLOR_INFO, at_ms(0), &camera_info(at_ms(0), "rgb_optical"));
        recorder.image(COLOR, at_ms(0), &color);
        recorder.depth(at_ms(0), 7);
        recorder.save()
    };
    let (frames, _) = read_mcap(&recording(true), &Config::default()).unwrap();
    assert_eq!(frames[0].color_from_depth.unwrap().translation_m.x, 0.05);
    let (frames, report) = read_mcap(&recording(false), &Config::default()).unwrap();
    assert!(frames[0].color.is_some() && frames[0].color_from_depth.is_none());
    assert!(noted(&report, "no transform from `cam_optical` to `rgb_optical`"), "{:?}", report.notes);
}

#[test]
fn the_camera_frame_can_be_configured() {
    let mut recorder = Recorder::new();
    recorder.transform("/tf", at_ms(0), ["map", "true_optical"], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]);
    recorder.color(at_ms(0), 3);
    recorder.depth(at_ms(0), 7);
    let config = Config { camera_frame: "true_optical".into(), ..Config::default() };
    let (frames, _) = read_mcap(&recorder.save(), &config).unwrap();
    assert_eq!(frames[0].depth.frame_id, "true_optical");
    assert!(frames[0].pose.is_some());
    assert_eq!(frames[0].color_from_depth, Some(Rigid::IDENTITY));
}
