//! Message and image formats.

use std::io::Cursor;

use byteorder::BigEndian;
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb};
use limpid::Config;
use limpid::input::LogReader;
use limpid::input::image_decode::{RawImage, depth_from_compressed};
use limpid::message::foxglove;
use limpid::message::ros2::{Image, decode_cdr};
use limpid::sensor::DepthSamples;

use super::synthetic::{COLOR, DEPTH, DEPTH_INFO, FRAME, Recorder, SIZE, at_ms, camera_info, depth_image};
use super::{noted, read_mcap};

fn raw<'a>(encoding: &'a str, [width, height]: [u32; 2], step: u32, data: &'a [u8]) -> RawImage<'a> {
    RawImage { width, height, step, encoding, big_endian: false, data }
}

#[test]
fn colour_encodings_give_rgb() {
    for (encoding, bytes) in [
        ("rgb8", &[10, 20, 30][..]),
        ("bgr8", &[30, 20, 10]),
        ("8UC3", &[30, 20, 10]),
        ("rgba8", &[10, 20, 30, 255]),
        ("bgra8", &[30, 20, 10, 0]),
        ("8UC4", &[30, 20, 10, 0]),
    ] {
        let decoded = raw(encoding, [1, 1], 4, bytes).color().unwrap();
        assert_eq!((decoded.width, decoded.height, decoded.samples), (1, 1, vec![10, 20, 30]), "{encoding}");
    }
    for encoding in ["mono8", "8UC1"] {
        assert_eq!(raw(encoding, [2, 1], 2, &[7, 9]).color().unwrap().samples, [7, 7, 7, 9, 9, 9]);
    }
}

#[test]
fn yuv_encodings_give_the_video_standards_colours() {
    // BT.601, studio range: red is Y 81, U 90, V 240; white Y 235, U V 128.
    let red_white = |encoding, bytes: [u8; 8]| raw(encoding, [4, 1], 8, &bytes).color().unwrap().samples;
    for (encoding, bytes) in [
        ("yuv422_yuy2", [81, 90, 81, 240, 235, 128, 16, 128]),
        ("yuyv", [81, 90, 81, 240, 235, 128, 16, 128]),
        ("yuv422", [90, 81, 240, 81, 128, 235, 128, 16]),
        ("uyvy", [90, 81, 240, 81, 128, 235, 128, 16]),
    ] {
        let expected = [255, 0, 0, 255, 0, 0, 255, 255, 255, 0, 0, 0];
        let found = red_white(encoding, bytes);
        for (found, expected) in found.iter().zip(expected) {
            assert!(found.abs_diff(expected) <= 2, "{encoding}: {found} against {expected}");
        }
    }
    assert!(raw("yuyv", [3, 1], 6, &[0; 6]).color().unwrap_err().to_string().contains("odd"));
}

#[test]
fn planes_of_yuv_give_the_video_standards_colours() {
    // Two by two pixels of red beside two by two of white, and the last column and row half a pair.
    let luma = [81, 81, 235, 81, 81, 235, 81, 81, 235];
    let pairs = [90, 240, 128, 128, 90, 240, 128, 128];
    let swapped = [240, 90, 128, 128, 240, 90, 128, 128];
    let padded = |rows: &[u8], length: usize| {
        rows.chunks(length).flat_map(|row| [row, &[7; 3]].concat()).collect::<Vec<_>>()
    };
    let full = [[90, 240].repeat(2), vec![128, 128]].concat().repeat(3);
    for (encoding, step, data) in [
        ("nv12", 3, [&luma[..], &pairs].concat()),
        ("nv21", 3, [&luma[..], &swapped].concat()),
        // Rows of six bytes, of which the last pair's is the seventh: pairs lie on even bytes.
        ("nv12", 6, [padded(&luma, 3), vec![90, 240, 128, 128, 7, 7, 90, 240, 128, 128]].concat()),
        // A step that counts both bytes of a pixel, though the rows have no gaps.
        ("nv12", 6, [&luma[..], &pairs].concat()),
        ("nv24", 3, [&luma[..], &full].concat()),
    ] {
        let color = raw(encoding, [3, 3], step, &data).color().unwrap();
        let expected = [[255, 0, 0], [255, 0, 0], [255, 255, 255]].concat().repeat(3);
        for (found, expected) in color.samples.iter().zip(expected) {
            assert!(found.abs_diff(expected) <= 2, "{encoding}, {step}: {:?}", color.samples);
        }
        let short = raw(encoding, [3, 3], step, &data[..15]).color();
        assert!(short.unwrap_err().to_string().contains("do not fit"), "{encoding}");
    }
}

#[test]
fn bayer_mosaics_and_wide_samples_give_their_colours() {
    // Red 200, green 90, blue 30.
    let rggb = [[200, 90].repeat(2), [90, 30].repeat(2)].concat().repeat(2);
    let color = raw("bayer_rggb8", [4, 4], 4, &rggb).color().unwrap();
    assert_eq!(color.samples, [200, 90, 30].repeat(16));
    let little: Vec<u8> = rggb.iter().flat_map(|&value| [99, value]).collect();
    assert_eq!(raw("bayer_rggb16", [4, 4], 8, &little).color().unwrap(), color);
    let big = RawImage { big_endian: true, ..raw("bayer_rggb16", [4, 4], 8, &little) };
    assert_ne!(big.color().unwrap(), color);
    for (encoding, bytes) in [("rgb16", [1, 10, 2, 20, 3, 30]), ("bgr16", [3, 30, 2, 20, 1, 10])] {
        assert_eq!(raw(encoding, [1, 1], 6, &bytes).color().unwrap().samples, [10, 20, 30], "{encoding}");
    }
    assert!(
        raw("bayer_rggb8", [4, 4], 3, &rggb).color().is_err()
            && raw("bayer_rg8", [1, 1], 1, &[1]).color().is_err()
    );
}

#[test]
fn rows_may_be_longer_than_their_pixels() {
    let data = [1, 0, 2, 0, 99, 99, 3, 0, 4, 0];
    let depth = raw("16UC1", [2, 2], 6, &data).depth(0.001).unwrap();
    assert_eq!(depth.samples, DepthSamples::Integer { raw: vec![1, 2, 3, 4], unit_m: 0.001 });
    let color = raw("mono8", [1, 2], 4, &[5, 0, 0, 0, 6]).color().unwrap();
    assert_eq!(color.samples, [5, 5, 5, 6, 6, 6]);
}

#[test]
fn byte_order_is_honoured() {
    let big = |encoding, data| RawImage { big_endian: true, ..raw(encoding, [1, 1], 4, data) };
    assert_eq!(
        big("mono16", &[1, 2]).depth(0.5).unwrap().samples,
        DepthSamples::Integer { raw: vec![0x0102], unit_m: 0.5 }
    );
    assert_eq!(
        big("32FC1", &1.5_f32.to_be_bytes()).depth(0.5).unwrap().samples,
        DepthSamples::Metres(vec![1.5])
    );
    assert_eq!(
        raw("32FC1", [1, 1], 4, &1.5_f32.to_le_bytes()).depth(0.5).unwrap().samples,
        DepthSamples::Metres(vec![1.5])
    );
}

#[test]
fn confidence_is_a_share() {
    assert_eq!(raw("mono8", [3, 1], 3, &[0, 51, 255]).confidence().unwrap().samples, [0.0, 0.2, 1.0]);
    let floats: Vec<u8> =
        [0.25, -1.0, 7.0, f32::NAN].iter().flat_map(|share: &f32| share.to_le_bytes()).collect();
    assert_eq!(raw("32FC1", [4, 1], 16, &floats).confidence().unwrap().samples, [0.25, 0.0, 1.0, 0.0]);
}

fn png(samples: Vec<u16>) -> Vec<u8> {
    let image: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::from_raw(SIZE[0], SIZE[1], samples).unwrap();
    file(DynamicImage::ImageLuma16(image), ImageFormat::Png)
}

fn file(image: DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

#[test]
fn compressed_images_are_read() {
    let samples: Vec<u16> = (0..12).map(|n| 100 * n).collect();
    let mut recorder = Recorder::new();
    let topic = "/cam/depth/image_raw/compressedDepth";
    recorder.info(DEPTH_INFO, at_ms(0), &camera_info(at_ms(0), FRAME));
    let payload = [&[0; 12][..], &png(samples.clone())].concat();
    recorder.compressed_image(topic, at_ms(0), "16UC1; compressedDepth png", payload);
    recorder.compressed_image(topic, at_ms(10), "16UC1; png compressed", png(samples.clone()));
    let grey = ImageBuffer::from_pixel(SIZE[0], SIZE[1], Rgb([90_u8, 90, 90]));
    let jpeg = file(DynamicImage::ImageRgb8(grey), ImageFormat::Jpeg);
    recorder.compressed_image(
        "/cam/color/image_raw/compressed",
        at_ms(0),
        "rgb8; jpeg compressed bgr8",
        jpeg,
    );
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    assert_eq!(frames.len(), 2, "{report:?}");
    for frame in &frames {
        assert_eq!(frame.depth.samples, DepthSamples::Integer { raw: samples.clone(), unit_m: 0.001 });
    }
    let rgb = &frames[0].color.as_ref().unwrap().rgb;
    assert!(rgb.len() == 36 && rgb.iter().all(|value| value.abs_diff(90) <= 2), "{rgb:?}");
}

#[test]
fn quantised_inverse_depth_is_unpacked() {
    let (a, b) = (2000.0_f32, -50.0_f32);
    let header = [&[0; 4][..], &a.to_le_bytes(), &b.to_le_bytes()].concat();
    let payload = [header, png([vec![0, 950, 450], vec![1950; 9]].concat())].concat();
    let decoded = depth_from_compressed("32FC1; compressedDepth png", &payload, 0.001).unwrap();
    let DepthSamples::Metres(depth_m) = decoded.samples else { panic!("metres are meant") };
    assert!(depth_m[0].is_nan());
    assert_eq!(depth_m[1..4], [2.0, 4.0, 1.0]);
}

#[test]
fn depth_that_cannot_be_read_says_why() {
    let eight_bits = file(DynamicImage::new_luma8(4, 3), ImageFormat::Png);
    for (format, payload, part) in [
        ("16UC1; compressedDepth rvl", vec![0; 40], "RVL image: its size is 0x0"),
        ("16UC1; compressedDepth rvl", vec![0; 19], "ends within its size"),
        ("16UC1; compressedDepth rvl", rvl(9000, 1, &[]), "its size is 9000x1"),
        ("16UC1; compressedDepth rvl", rvl(8192, 8192, &[]), "its size is 8192x8192"),
        ("16UC1; compressedDepth rvl", rvl(4, 3, &[]), "after 0 of 12 pixels"),
        ("16UC1; compressedDepth rvl", rvl(4, 3, &[0x5000_0000]), "after 5 of 12 pixels"),
        ("16UC1; compressedDepth rvl", rvl(4, 3, &[0xd100_0000]), "a run of 13 pixels after 0"),
        ("16UC1; compressedDepth rvl", rvl(4, 3, &[0xffff_ffff; 9]), "a number that is none"),
        ("16UC1; compressedDepth png", vec![0; 11], "header of 12 bytes"),
        ("16UC1; compressedDepth png", vec![0; 40], "neither JPEG nor PNG"),
        ("png", eight_bits, "16-bit grey"),
        ("png", png(vec![7; 12])[..60].to_vec(), "compressed depth image"),
    ] {
        let error = depth_from_compressed(format, &payload, 0.001).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}

/// A `compressedDepth` payload of RVL code: eight nibbles a word, the first the highest.
fn rvl(width: u32, height: u32, words: &[u32]) -> Vec<u8> {
    let code = words.iter().flat_map(|word| word.to_le_bytes());
    [0; 12].into_iter().chain(width.to_le_bytes()).chain(height.to_le_bytes()).chain(code).collect()
}

#[test]
fn truth_rvl_is_read_by_hand() {
    // 4x3: 3 zeros, then 700, 701, 698, 65535; 4 zeros, then 1. A nibble has three bits of a number, the lowest first, and
    // says in its highest bit whether more follow; differences carry their sign in the lowest bit.
    // Runs 3 and 4; +700 = 1400 = 0o2570: 8+0, 8+7, 8+5, 2; +1 = 2; -3 = 5; 64837 = 129674 = 0o375212: 8+2, 8+1, 8+2, 8+5, 8+7, 3;
    // runs 4 and 1; 1 - 65535 = -65534 = 131067 = 0o377773: 8+3, 8+7, 8+7, 8+7, 8+7, 3.
    let words = [0x348f_d225, 0xa9ad_f341, 0xbfff_f300];
    let decoded = depth_from_compressed("16UC1; compressedDepth rvl", &rvl(4, 3, &words), 0.001).unwrap();
    let want = vec![0, 0, 0, 700, 701, 698, 65535, 0, 0, 0, 0, 1];
    assert_eq!(decoded.samples, DepthSamples::Integer { raw: want, unit_m: 0.001 });
    assert_eq!((decoded.width, decoded.height), (4, 3));
    // Only zeros take two nibbles: 12 = 0o14.
    let zeros =
        depth_from_compressed("16uc1; compresseddepth RVL", &rvl(4, 3, &[0xc100_0000]), 0.001).unwrap();
    assert_eq!(zeros.samples, DepthSamples::Integer { raw: vec![0; 12], unit_m: 0.001 });
}

#[test]
fn truth_rvl_of_inverse_depth_is_unpacked() {
    let (a, b) = (2000.0_f32, -50.0_f32);
    // 2x1: a hole, then 950 = 1900 = 0o3554: 8+4, 8+5, 8+5, 3.
    let mut payload = rvl(2, 1, &[0x11cd_d300]);
    payload[4..8].copy_from_slice(&a.to_le_bytes());
    payload[8..12].copy_from_slice(&b.to_le_bytes());
    let decoded = depth_from_compressed("32FC1; compressedDepth rvl", &payload, 0.001).unwrap();
    let DepthSamples::Metres(depth_m) = decoded.samples else { panic!("metres are meant") };
    assert!(depth_m[0].is_nan() && depth_m[1] == 2.0, "{depth_m:?}");
}

#[test]
fn huge_images_are_refused_before_they_are_decoded() {
    let mut bytes = png(vec![7; 12]);
    // The width in the PNG's first chunk; its checksum no longer fits, which must not matter.
    bytes[16..20].copy_from_slice(&u32::MAX.to_be_bytes());
    assert!(depth_from_compressed("png", &bytes, 0.001).is_err());
}

#[test]
fn big_endian_cdr_is_read() {
    let mut recorder = Recorder::new();
    recorder.info(DEPTH_INFO, at_ms(0), &camera_info(at_ms(0), FRAME));
    let mut payload = vec![0, 0, 0, 0];
    cdr_encoding::to_writer::<Image, BigEndian, _>(&mut payload, &depth_image(at_ms(0), 700)).unwrap();
    recorder.bytes(DEPTH, "sensor_msgs/msg/Image", "cdr", at_ms(0), &payload);
    let (frames, _) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    assert_eq!(frames[0].depth.stamp_ns, at_ms(0));
    assert_eq!(frames[0].depth.samples, DepthSamples::Integer { raw: vec![700; 12], unit_m: 0.001 });
    let other: limpid::Result<Image> = decode_cdr("Image", &[0, 7, 0, 0, 1]);
    assert!(other.unwrap_err().to_string().contains("encapsulation 0x00 0x07"));
}

fn foxglove_recording() -> Recorder {
    let timestamp = Some(foxglove::Timestamp { seconds: 1000, nanos: 0 });
    let calibration = foxglove::CameraCalibration {
        timestamp,
        width: SIZE[0],
        height: SIZE[1],
        k: vec![5.0, 0.0, 2.0, 0.0, 6.0, 1.5, 0.0, 0.0, 1.0],
        frame_id: FRAME.into(),
        ..Default::default()
    };
    let image = |encoding: &str, step: u32, data: Vec<u8>| foxglove::RawImage {
        timestamp,
        width: SIZE[0],
        height: SIZE[1],
        encoding: encoding.into(),
        step,
        data,
        frame_id: FRAME.into(),
    };
    let transform = foxglove::FrameTransform {
        timestamp,
        parent_frame_id: "map".into(),
        child_frame_id: FRAME.into(),
        translation: Some(foxglove::Vector3 { x: 1.0, y: 2.0, z: 3.0 }),
        rotation: Some(foxglove::Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 2.0 }),
    };
    let transforms = foxglove::FrameTransforms { transforms: vec![transform] };
    let mut recorder = Recorder::new();
    recorder.foxglove("/calibration", "foxglove.CameraCalibration", at_ms(0), &calibration);
    recorder.foxglove("/tf", "foxglove.FrameTransforms", at_ms(0), &transforms);
    recorder.foxglove(COLOR, "foxglove.RawImage", at_ms(0), &image("rgb8", 12, vec![8; 36]));
    recorder.foxglove(DEPTH, "foxglove.RawImage", at_ms(0), &image("16UC1", 8, vec![1; 24]));
    recorder
}

#[test]
fn foxglove_messages_are_read() {
    let (frames, report) = read_mcap(&foxglove_recording().save(), &Config::default()).unwrap();
    assert!(report.skipped.is_empty(), "{report:?}");
    let frame = &frames[0];
    assert_eq!((frame.depth.stamp_ns, frame.depth.camera.fy), (at_ms(0), 6.0));
    assert_eq!(frame.depth.samples, DepthSamples::Integer { raw: vec![0x0101; 12], unit_m: 0.001 });
    assert_eq!(frame.color.as_ref().unwrap().rgb, vec![8; 36]);
    let pose = frame.pose.unwrap();
    let at = pose.map_from_base.then(pose.base_from_camera).translation_m;
    assert!(at.abs_diff_eq(glam::DVec3::new(1.0, 2.0, 3.0), 1e-12), "{at}");
    assert!(noted(&report, "calibration by frame"), "{:?}", report.notes);
}

#[test]
fn topics_are_chosen_by_type_and_name() {
    let mut recorder = foxglove_recording();
    for topic in ["/cam/infra1/image_raw", "/cam/depth/confidence", "/zed/rgb/image", "/cam/image_of_nothing"]
    {
        recorder.channel(topic, "foxglove.RawImage", "protobuf");
    }
    recorder.channel("/a/depth", "foxglove.CompressedImage", "protobuf");
    let reader = LogReader::mcap(&recorder.save().path, &Config::default()).unwrap();
    let notes = &limpid::input::Recording::report(&reader).notes;
    assert!(notes[0].starts_with(&format!("topics: depth {DEPTH} ")), "{notes:?}");
    assert!(notes[0].contains(&format!("colour {COLOR} ")), "{notes:?}");
}

#[test]
fn compressed_depth_of_a_colour_image_is_not_taken_for_depth() {
    let mut recorder = Recorder::new();
    recorder.info(DEPTH_INFO, at_ms(0), &camera_info(at_ms(0), FRAME));
    for camera in ["a/color", "cam/depth"] {
        let topic = format!("/{camera}/image_raw/compressedDepth");
        let payload = [&[0; 12][..], &png(vec![9; 12])].concat();
        recorder.compressed_image(&topic, at_ms(0), "16UC1; compressedDepth png", payload);
    }
    let reader = LogReader::mcap(&recorder.save().path, &Config::default()).unwrap();
    let notes = &limpid::input::Recording::report(&reader).notes;
    assert!(notes[0].starts_with("topics: depth /cam/depth/image_raw/compressedDepth "), "{notes:?}");
    assert!(notes[0].contains("colour none"), "{notes:?}");
}

#[test]
fn slashes_before_frames_of_foxglove_mean_nothing() {
    let (timestamp, [width, height]) = (Some(foxglove::Timestamp { seconds: 1000, nanos: 0 }), SIZE);
    let frame_id = format!("/{FRAME}");
    let mut recorder = Recorder::new();
    recorder.transform("/tf_static", at_ms(0), ["map", FRAME], [0.0; 3], [0.0, 0.0, 0.0, 1.0]);
    let k = vec![5.0, 0.0, 2.0, 0.0, 6.0, 1.5, 0.0, 0.0, 1.0];
    let info = foxglove::CameraCalibration {
        timestamp,
        width,
        height,
        k,
        frame_id: FRAME.into(),
        ..Default::default()
    };
    recorder.foxglove("/calibration", "foxglove.CameraCalibration", at_ms(0), &info);
    let data = depth_image(at_ms(0), 7).data;
    let image = foxglove::RawImage {
        timestamp,
        width,
        height,
        encoding: "16UC1".into(),
        step: 2 * width,
        data,
        frame_id,
    };
    recorder.foxglove(DEPTH, "foxglove.RawImage", at_ms(0), &image);
    let (frames, report) = read_mcap(&recorder.save(), &Config::default()).unwrap();
    assert!(frames.len() == 1 && frames[0].pose.is_some(), "{report:?}");
}
