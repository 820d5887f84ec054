//! Random and truncated input: errors or frames, never a panic.

use limpid::Config;
use limpid::input::image_decode::{RawImage, color_from_file, depth_from_compressed};
use limpid::input::{LogReader, Recording};
use limpid::message::foxglove;
use limpid::message::foxglove::decode_protobuf;
use limpid::message::lidar::{
    ChannelFloat32, CustomMsg, CustomPoint, LaserScan, MultiEchoLaserScan, Point32, PointCloud,
};
use limpid::message::ros2::{
    CameraInfo, CompressedImage, Image, OdometryPose, TFMessage, decode_cdr, encode_cdr,
};
use prop::collection::vec;
use proptest::prelude::*;

use super::read_mcap;
use super::synthetic::{
    DEPTH, DEPTH_INFO, FRAME, Recorder, at_ms, camera_info, depth_image, header, save, transform,
};

const ENCODINGS: [&str; 13] = [
    "rgb8",
    "bgra8",
    "mono8",
    "yuyv",
    "uyvy",
    "bgr16",
    "bayer_gbrg8",
    "bayer_rggb16",
    "nv12",
    "nv24",
    "16UC1",
    "32FC1",
    "x",
];

/// Bytes that a decoded message holds may not exceed those it came in.
fn bounded(message: limpid::Result<Image>, payload: &[u8]) -> bool {
    message.map_or(true, |image| image.data.len() + image.encoding.len() <= payload.len())
}

/// Topic, type and payload of a sound message of every kind that a recording's reader knows beside images.
fn sound_messages() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let header = || header(at_ms(0), FRAME);
    let places = [[1.0, 2.0, 0.5], [2.0, -1.0, 0.1]].map(|[x, y, z]| Point32 { x, y, z });
    let channels = vec![ChannelFloat32 { name: "intensity".into(), values: vec![3.0, 4.0] }];
    let flat = LaserScan {
        header: header(),
        angle_increment: 0.1,
        range_max: 9.0,
        ranges: vec![1.0; 4],
        ..LaserScan::default()
    };
    let echoes =
        MultiEchoLaserScan { header: header(), angle_increment: 0.1, range_max: 9.0, ..Default::default() };
    let points = vec![CustomPoint { x: 1.0, ..CustomPoint::default() }; 2];
    let livox = CustomMsg { header: header(), point_num: 2, points, ..CustomMsg::default() };
    let tf =
        TFMessage { transforms: vec![transform(at_ms(0), ["map", FRAME], [0.0; 3], [0.0, 0.0, 0.0, 1.0])] };
    let cdr = |bytes: limpid::Result<Vec<u8>>| bytes.unwrap();
    vec![
        (DEPTH_INFO, "sensor_msgs/msg/CameraInfo", cdr(encode_cdr("", &camera_info(at_ms(0), FRAME)))),
        (DEPTH, "sensor_msgs/msg/Image", cdr(encode_cdr("", &depth_image(at_ms(0), 7)))),
        ("/tf", "tf2_msgs/msg/TFMessage", cdr(encode_cdr("", &tf))),
        (
            "/points",
            "sensor_msgs/msg/PointCloud",
            cdr(encode_cdr("", &PointCloud { header: header(), points: places.into(), channels })),
        ),
        ("/scan", "sensor_msgs/msg/LaserScan", cdr(encode_cdr("", &flat))),
        ("/scan", "sensor_msgs/msg/MultiEchoLaserScan", cdr(encode_cdr("", &echoes))),
        ("/livox", "livox_ros_driver2/msg/CustomMsg", cdr(encode_cdr("", &livox))),
    ]
}

fn small_recording() -> Vec<u8> {
    let mut recorder = Recorder::compressed(Some(mcap::Compression::Lz4));
    for ms in [0, 33, 66] {
        recorder.transform("/tf", at_ms(ms), ["map", FRAME], [0.0; 3], [0.0, 0.0, 0.0, 1.0]);
        recorder.depth(at_ms(ms), 7);
    }
    recorder.finish()
}

#[test]
fn truncated_messages_are_errors() {
    let image = encode_cdr("Image", &depth_image(at_ms(0), 7)).unwrap();
    let info = encode_cdr("CameraInfo", &camera_info(at_ms(0), FRAME)).unwrap();
    let tf = TFMessage { transforms: vec![transform(at_ms(0), ["a", "b"], [0.0; 3], [0.0; 4])] };
    let tf = encode_cdr("TFMessage", &tf).unwrap();
    assert!(decode_cdr::<Image>("", &image).is_ok() && decode_cdr::<CameraInfo>("", &info).is_ok());
    assert!(decode_cdr::<TFMessage>("", &tf).is_ok());
    for cut in 0..image.len() {
        assert!(decode_cdr::<Image>("", &image[..cut]).is_err(), "cut at {cut}");
    }
    for cut in 0..info.len() {
        assert!(decode_cdr::<CameraInfo>("", &info[..cut]).is_err(), "cut at {cut}");
    }
    for cut in 0..tf.len() {
        assert!(decode_cdr::<TFMessage>("", &tf[..cut]).is_err(), "cut at {cut}");
    }
}

#[test]
fn lengths_beyond_the_payload_are_errors() {
    let tf = [&[0, 1, 0, 0][..], &u32::MAX.to_le_bytes(), &[0; 64]].concat();
    assert!(decode_cdr::<TFMessage>("", &tf).is_err());
    let mut image = encode_cdr("Image", &depth_image(at_ms(0), 7)).unwrap();
    let length_at = image.len() - 24 - 4;
    image[length_at..length_at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(decode_cdr::<Image>("", &image).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_messages_do_not_panic(mut bytes in vec(any::<u8>(), 0..300), little in any::<bool>()) {
        if bytes.len() > 1 {
            (bytes[0], bytes[1]) = (0, u8::from(little));
        }
        prop_assert!(bounded(decode_cdr("", &bytes), &bytes));
        let tf = decode_cdr::<TFMessage>("", &bytes);
        // A transform takes more than 64 bytes.
        prop_assert!(tf.map_or(0, |tf| tf.transforms.len()) * 64 <= bytes.len());
        let d = decode_cdr::<CameraInfo>("", &bytes).map_or(0, |info| info.d.len());
        prop_assert!(8 * d <= bytes.len());
        let data = decode_cdr::<CompressedImage>("", &bytes).map_or(0, |image| image.data.len());
        prop_assert!(data <= bytes.len());
        prop_assert!(bytes.len() > 288 || decode_cdr::<OdometryPose>("", &bytes).is_err());
        let raw = decode_protobuf::<foxglove::RawImage>("", &bytes).map_or(0, |image| image.data.len());
        prop_assert!(raw <= bytes.len());
        let k = decode_protobuf::<foxglove::CameraCalibration>("", &bytes).map_or(0, |info| info.k.len());
        prop_assert!(8 * k <= bytes.len());
    }

    #[test]
    fn random_rvl_gives_all_its_pixels_or_none(
        size in prop::array::uniform2(0_u32..24),
        word in any::<u32>(),
        code in vec(any::<u8>(), 0..200),
    ) {
        let header = [0_u8; 12].into_iter();
        let sized = header.clone().chain(size.into_iter().flat_map(u32::to_le_bytes)).chain(code.clone());
        let claimed = header.chain(word.to_le_bytes()).chain(word.rotate_left(7).to_le_bytes()).chain(code);
        for payload in [sized.collect::<Vec<_>>(), claimed.collect()] {
            if let Ok(depth) = depth_from_compressed("16UC1; compressedDepth rvl", &payload, 0.001) {
                prop_assert_eq!(depth.samples.len(), depth.width as usize * depth.height as usize);
            }
        }
    }

    #[test]
    fn random_raw_images_do_not_panic(
        size in any::<[u32; 3]>(),
        small in any::<[bool; 3]>(),
        encoding in prop::sample::select(ENCODINGS.to_vec()),
        big_endian in any::<bool>(),
        data in vec(any::<u8>(), 0..200),
    ) {
        let pick = |at: usize| if small[at] { size[at] % 20 } else { size[at] };
        let image = RawImage { width: pick(0), height: pick(1), step: pick(2), encoding, big_endian, data: &data };
        // At most three bytes come of one (mono8), and at least a byte of the payload is behind each pixel.
        let pixels = pick(0) as usize * pick(1) as usize;
        if let Ok(color) = image.color() {
            prop_assert!(color.samples.len() == 3 * pixels && pixels <= data.len());
        }
        if let Ok(depth) = image.depth(0.001) {
            prop_assert!(depth.samples.len() == pixels && 2 * pixels <= data.len());
        }
        if let Ok(confidence) = image.confidence() {
            prop_assert!(confidence.samples.len() == pixels && pixels <= data.len());
        }
    }

    #[test]
    fn random_image_files_do_not_panic(data in vec(any::<u8>(), 0..200), jpeg in any::<bool>()) {
        let start: &[u8] = if jpeg { &[0xff, 0xd8, 0xff] } else { b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" };
        let file = [start, &data].concat();
        if let Ok(image) = color_from_file(&file) {
            prop_assert_eq!(image.samples.len(), 3 * image.width as usize * image.height as usize);
        }
        let payload = [&[0; 12][..], &file].concat();
        for format in ["16UC1; compressedDepth png", "32FC1; compressedDepth png"] {
            if let Ok(image) = depth_from_compressed(format, &payload, 0.001) {
                prop_assert_eq!(image.samples.len(), image.width as usize * image.height as usize);
            }
        }
    }

    #[test]
    fn recordings_with_changed_bytes_do_not_panic(changes in vec((any::<prop::sample::Index>(), any::<u8>()), 1..12)) {
        let mut bytes = small_recording();
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        if let Ok((frames, report)) = read_mcap(&save(&bytes), &Config::default()) {
            prop_assert!(frames.len() as u64 <= report.depth_images && report.depth_images <= 3);
        }
    }

    #[test]
    fn changed_messages_of_every_type_do_not_panic(
        kind in 0_usize..7,
        changes in vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        cut in any::<prop::sample::Index>(),
        whole in any::<bool>(),
    ) {
        let mut recorder = Recorder::new();
        for (at, (topic, schema, mut payload)) in sound_messages().into_iter().enumerate() {
            if at == kind {
                for (at, value) in &changes {
                    let at = at.index(payload.len());
                    payload[at] = *value;
                }
                payload.truncate(if whole { payload.len() } else { cut.index(payload.len()) });
            }
            recorder.bytes(topic, schema, "cdr", at_ms(0), &payload);
        }
        let saved = recorder.save();
        let mut given = 0;
        if let Ok(mut source) = limpid::open_source(&saved.path, &Config::default()) {
            while let Ok(Some(_)) = source.next() {
                given += 1;
            }
        }
        prop_assert!(given <= 7);
    }

    #[test]
    fn random_files_are_not_recordings(tail in vec(any::<u8>(), 0..400)) {
        let bytes = [mcap::MAGIC, &tail].concat();
        let opened = LogReader::mcap(&save(&bytes).path, &Config::default());
        prop_assert!(opened.map_or(true, |mut reader| !matches!(reader.next_frame(), Ok(Some(_)))));
    }
}
