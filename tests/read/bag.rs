//! ROS 1 bags: another file's pixels, every compression, damage.

use glam::DVec3;
use limpid::base::Rigid;
use limpid::input::{LogReader, ReadReport, Recording, open};
use limpid::message::{ros1, ros2};
use limpid::sensor::{DepthSamples, RgbdFrame};
use limpid::{Config, Result};
use prop::collection::vec;
use proptest::prelude::*;

use super::real::config;
use super::ros1::{
    Bag, Compression, IMAGE, INFO, camera_info, depth_image, f64s, header, image, sized, stamped, u32s,
};
use super::synthetic::{COLOR, COLOR_INFO, DEPTH, DEPTH_INFO, FRAME, Recorder, Saved, at_ms, save};
use super::{noted, read_all, read_mcap, skipped};
use crate::support::data_dir;

const FRAMES: u16 = 12;

fn read(bytes: &[u8], config: &Config) -> Result<(Vec<RgbdFrame>, ReadReport)> {
    let saved: Saved = save(bytes);
    read_all(LogReader::bag(&saved.path, config)?)
}

/// Twelve depth images, two in a chunk.
fn recording(compression: Compression) -> Bag {
    let mut bag = Bag::new(compression);
    for number in 0..FRAMES {
        let stamp_ns = at_ms(100 * u64::from(number));
        bag.message(DEPTH_INFO, INFO, stamp_ns, &camera_info(stamp_ns, FRAME));
        bag.message(DEPTH, IMAGE, stamp_ns, &depth_image(stamp_ns, FRAME, 1000 + number));
        if number % 2 == 1 {
            bag.end_chunk();
        }
    }
    bag
}

/// How much the numbers of two transforms differ.
fn apart(a: Rigid, b: Rigid) -> f64 {
    let turned = a.rotation.angle_between(b.rotation);
    turned.max((a.translation_m - b.translation_m).abs().max_element())
}

#[test]
fn the_sdks_bag_gives_what_its_mcap_file_gives() {
    let bag = data_dir("rgbd/librealsense-d435-bag/single_depth_color_640x480.bag");
    let mcap = data_dir("rgbd/mcap-derived/librealsense_d435_unaligned_ros2_cdr.mcap");
    let (Some(bag), Some(mcap)) = (bag, mcap) else { return };
    let mut bag = open(&bag, &config("realsense-bag.yaml")).unwrap();
    let (expected, _) =
        read_all(LogReader::mcap(&mcap, &config("realsense-unaligned.yaml")).unwrap()).unwrap();
    assert_eq!((bag.frame_count_hint(), expected.len()), (Some(2), 2));
    for expected in &expected {
        let frame = bag.next_frame().unwrap().unwrap();
        assert_eq!((frame.index, frame.depth.stamp_ns), (expected.index, expected.depth.stamp_ns));
        assert_eq!(frame.depth.camera, expected.depth.camera);
        assert!(frame.depth.samples == expected.depth.samples, "depths differ");
        assert!(frame.color == expected.color && frame.color.is_some(), "colours differ");
        let off = apart(frame.color_from_depth.unwrap(), expected.color_from_depth.unwrap());
        assert!(off < 1e-6, "colour from depth is off by {off}");
        assert!(apart(frame.color_from_depth.unwrap().inverse(), expected.color_from_depth.unwrap()) > 0.01);
        let (pose, expected) = (frame.pose.unwrap(), expected.pose.unwrap());
        assert!(apart(pose.base_from_camera, expected.base_from_camera) < 1e-6);
        assert!(apart(pose.map_from_base, expected.map_from_base) < 1e-6);
    }
    assert!(bag.next_frame().unwrap().is_none());
    assert!(bag.report().skipped.is_empty(), "{:?}", bag.report());
    assert_eq!(bag.report().notes.len(), 2, "{:?}", bag.report());
    assert!(noted(bag.report(), "`depth_0_optical_frame` and `color_0_optical_frame`"));
}

/// A bag in the SDK's layout: the reference in depth is at x = 1, in colour at x = 5.
fn sdk_bag(color_reference: &str) -> Vec<u8> {
    let (depth, color) = ("/device_0/sensor_0/Depth_0", "/device_0/sensor_1/Color_0");
    let mut bag = Bag::new(Compression::Bz2);
    let transform = |x: f64| f64s(&[x, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    let pixels = image(at_ms(0), "7", "rgb8", 12, &[9; 36]);
    bag.message(&format!("{color}/tf/{color_reference}"), "geometry_msgs/Transform", 1, &transform(5.0));
    bag.message("/device_0/sensor_2/Gyro_0/tf/0", "geometry_msgs/Transform", 1, &transform(8.0));
    bag.message(&format!("{color}/info/camera_info"), INFO, 1, &camera_info(0, ""));
    bag.message(&format!("{color}/image/data"), IMAGE, at_ms(0), &pixels);
    bag.message(&format!("{depth}/info/camera_info"), INFO, 1, &camera_info(0, ""));
    bag.message(&format!("{depth}/image/data"), IMAGE, at_ms(0), &depth_image(at_ms(0), "7", 700));
    bag.message(&format!("{depth}/tf/0"), "geometry_msgs/Transform", 1, &transform(1.0));
    bag.finish()
}

#[test]
fn the_sdks_transforms_meet_in_their_reference() {
    let (frames, _) = read(&sdk_bag("0"), &Config::default()).unwrap();
    assert_eq!(frames[0].depth.frame_id, "depth_0_optical_frame");
    assert_eq!(frames[0].color_from_depth.unwrap().translation_m, DVec3::new(4.0, 0.0, 0.0));
    let (frames, report) = read(&sdk_bag("1"), &Config::default()).unwrap();
    assert_eq!(frames[0].color_from_depth, None, "two references are not linked");
    assert!(
        noted(&report, "no transform from `depth_0_optical_frame` to `color_0_optical_frame`"),
        "{report:?}"
    );
}

#[test]
fn a_unit_of_depth_that_is_not_the_recordings_is_told() {
    let Some(path) = data_dir("rgbd/librealsense-d435-bag/single_depth_color_640x480.bag") else { return };
    let config = Config { depth_unit_m: 0.0001, ..config("realsense-bag.yaml") };
    let (_, report) = read_all(LogReader::bag(&path, &config).unwrap()).unwrap();
    assert!(noted(&report, "a count of depth is 0.001 m, but depth_unit_m is 0.0001 m"), "{report:?}");
}

#[test]
fn every_compression_gives_the_same_frames() {
    for compression in Compression::ALL {
        let bytes = recording(compression).finish();
        let hint = LogReader::bag(&save(&bytes).path, &Config::default()).unwrap().frame_count_hint();
        assert_eq!(hint, Some(12), "{compression:?}");
        let (frames, report) = read(&bytes, &Config::default()).unwrap();
        assert_eq!((frames.len(), report.depth_images), (12, 12), "{compression:?}: {report:?}");
        assert_eq!(report.notes.len(), 1, "{report:?}");
        for (number, frame) in (0_u16..).zip(&frames) {
            assert_eq!(frame.depth.stamp_ns, at_ms(100 * u64::from(number)));
            let raw = vec![1000 + number; 12];
            assert_eq!(frame.depth.samples, DepthSamples::Integer { raw, unit_m: 0.001 });
            assert_eq!((frame.depth.camera.fy, frame.depth.frame_id.as_str()), (6.0, FRAME));
        }
    }
}

#[test]
fn a_bag_that_was_not_closed_is_read_in_full() {
    for compression in Compression::ALL {
        let (frames, report) = read(&recording(compression).unclosed(), &Config::default()).unwrap();
        assert_eq!(frames.len(), 12);
        assert!(noted(&report, "no summary") && noted(&report, "was not closed"), "{:?}", report.notes);
    }
}

#[test]
fn a_cut_off_bag_keeps_the_frames_before_the_cut() {
    for compression in Compression::ALL {
        let chunks_at = recording(compression).chunks_at;
        let index_at = chunks_at[chunks_at.len() - 1];
        let whole = recording(compression).finish();
        let mut before = 0;
        for cut in (0..whole.len()).step_by(17) {
            let found = read(&whole[..cut], &Config::default()).map_or(0, |(frames, report)| {
                let told = if cut < index_at { "cut off" } else { "no summary" };
                assert!(noted(&report, told), "cut at {cut}: {:?}", report.notes);
                frames.len()
            });
            let sure = 2 * chunks_at[1..].iter().filter(|&&end| end <= cut).count();
            assert!(
                (sure..=sure + 2).contains(&found),
                "{found} frames before the cut at {cut}, {sure} are sure"
            );
            assert!(
                found >= before,
                "{found} frames before the cut at {cut}, {before} before an earlier one"
            );
            before = found;
        }
        assert_eq!(before, 12, "{compression:?}");
        // What is not packed is not lost in a chunk that is cut.
        let found = read(&whole[..index_at - 40], &Config::default()).unwrap().0.len();
        assert!(compression != Compression::None || found >= 11, "{found}");
    }
}

#[test]
fn a_damaged_chunk_costs_its_own_messages_only() {
    for compression in [Compression::Lz4, Compression::Bz2] {
        let chunks_at = recording(compression).chunks_at;
        let mut bytes = recording(compression).finish();
        bytes[chunks_at[3] + 100..chunks_at[3] + 140].fill(0xaa);
        let (frames, report) = read(&bytes, &Config::default()).unwrap();
        let part = format!("chunk at byte {} is damaged", chunks_at[3]);
        assert!(noted(&report, &part), "{compression:?}: {:?}", report.notes);
        assert!((10..12).contains(&frames.len()), "{compression:?}: {} frames", frames.len());
        assert_eq!(frames.last().unwrap().depth.stamp_ns, at_ms(1100));
    }
}

/// A pair with transforms, the map's by `topic`.
fn posed(topic: &str, type_name: &str, frames: [&str; 2]) -> Vec<u8> {
    let mut bag = Bag::new(Compression::Lz4);
    let pose = [1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0];
    let mut map = stamped(at_ms(0), frames, &pose);
    if type_name == "nav_msgs/Odometry" {
        map.extend(f64s(&[0.0; 36 + 6 + 36]));
    } else {
        map = [u32s(&[1]), map].concat();
    }
    let camera = stamped(at_ms(0), ["/base_link", FRAME], &[0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0]);
    bag.message("/tf_static", "tf2_msgs/TFMessage", at_ms(0), &[u32s(&[1]), camera].concat());
    bag.message(topic, type_name, at_ms(0), &map);
    bag.message(COLOR_INFO, INFO, at_ms(0), &camera_info(at_ms(0), FRAME));
    bag.message(COLOR, IMAGE, at_ms(0), &image(at_ms(0), FRAME, "bgr8", 12, &[1, 2, 3].repeat(12)));
    bag.message(DEPTH_INFO, INFO, at_ms(0), &camera_info(at_ms(0), FRAME));
    bag.message(DEPTH, IMAGE, at_ms(0), &depth_image(at_ms(0), FRAME, 700));
    bag.finish()
}

#[test]
fn poses_come_from_tf_of_either_package_and_from_odometry() {
    let odometry = Config { odometry_topic: "/odom".into(), ..Config::default() };
    for (topic, type_name, config) in [
        ("/tf", "tf2_msgs/TFMessage", Config::default()),
        ("/tf", "tf/tfMessage", Config::default()),
        ("/odom", "nav_msgs/Odometry", odometry),
    ] {
        let (frames, report) = read(&posed(topic, type_name, ["/map", "/base_link"]), &config).unwrap();
        assert!(report.skipped.is_empty(), "{type_name}: {report:?}");
        let pose = frames[0].pose.unwrap();
        assert_eq!(pose.map_from_base.translation_m, DVec3::new(1.0, 2.0, 3.0), "{type_name}");
        assert_eq!(pose.base_from_camera.translation_m, DVec3::new(0.0, 0.0, 0.5), "{type_name}");
        assert_eq!(frames[0].color.as_ref().unwrap().rgb, [3, 2, 1].repeat(12));
        assert_eq!(frames[0].color_from_depth, Some(Rigid::IDENTITY));
    }
}

#[test]
fn a_message_that_does_not_decode_is_counted() {
    let mut bag = recording(Compression::None);
    let short = depth_image(at_ms(5000), FRAME, 1);
    bag.message(DEPTH, IMAGE, at_ms(5000), &short[..short.len() - 1]);
    let (frames, report) = read(&bag.finish(), &Config::default()).unwrap();
    assert_eq!((frames.len(), report.depth_images), (12, 13));
    assert_eq!(skipped(&report, "ends early"), 1, "{report:?}");
    let skip = report.skipped.iter().find(|skip| skip.reason.contains("ends early")).unwrap();
    assert_eq!((skip.source.as_str(), skip.first_stamp_ns), (DEPTH, at_ms(5000)));
}

#[test]
fn ros_1_messages_in_mcap_are_read() {
    let mut recorder = Recorder::new();
    recorder.bytes(DEPTH_INFO, INFO, "ros1", at_ms(0), &camera_info(at_ms(0), FRAME));
    let jpeg = [header(at_ms(0), FRAME), sized(b"jpeg"), sized(b"none")].concat();
    recorder.bytes(COLOR, "sensor_msgs/CompressedImage", "ros1", at_ms(0), &jpeg);
    recorder.bytes(DEPTH, IMAGE, "ros1", at_ms(0), &depth_image(at_ms(0), FRAME, 700));
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    assert_eq!(frames[0].depth.samples, DepthSamples::Integer { raw: vec![700; 12], unit_m: 0.001 });
    assert_eq!(skipped(&report, "neither JPEG nor PNG"), 1, "{report:?}");
}

#[test]
fn truncated_messages_are_errors() {
    let (image, info) = (depth_image(at_ms(0), FRAME, 7), camera_info(at_ms(0), FRAME));
    let decoded: ros2::Image = ros1::decode("", &image).unwrap();
    assert_eq!((decoded.header.frame_id.as_str(), decoded.width, decoded.data.len()), (FRAME, 4, 24));
    assert!(ros1::decode::<ros2::CameraInfo>("", &info).is_ok());
    for cut in 0..image.len() {
        assert!(ros1::decode::<ros2::Image>("", &image[..cut]).is_err(), "cut at {cut}");
    }
    for cut in 0..info.len() {
        assert!(ros1::decode::<ros2::CameraInfo>("", &info[..cut]).is_err(), "cut at {cut}");
    }
    let endless = [&u32::MAX.to_le_bytes()[..], &[0; 64]].concat();
    assert!(ros1::decode::<ros2::TFMessage>("", &endless).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 384, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn bags_with_changed_bytes_or_a_cut_do_not_panic(
        changes in vec((any::<prop::sample::Index>(), any::<u8>()), 0..12),
        cut in proptest::option::of(any::<prop::sample::Index>()),
        compression in prop::sample::select(Compression::ALL.to_vec()),
    ) {
        let mut bytes = recording(compression).finish();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        if let Ok((frames, report)) = read(&bytes, &Config::default()) {
            prop_assert!(frames.len() as u64 <= report.depth_images && report.depth_images <= 24);
        }
    }

    #[test]
    fn random_bags_are_not_recordings(tail in vec(any::<u8>(), 0..400), whole_header in any::<bool>()) {
        let start = if whole_header { Bag::new(Compression::None).unclosed() } else { b"#ROSBAG V2.0\n".to_vec() };
        let opened = LogReader::bag(&save(&[start, tail].concat()).path, &Config::default());
        prop_assert!(opened.map_or(true, |mut reader| !matches!(reader.next_frame(), Ok(Some(_)))));
    }
}
