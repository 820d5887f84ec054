//! Still pairs whose depth is an OpenEXR image.

use std::io::Cursor;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage, f16,
};
use glam::DVec3;
use limpid::Config;
use limpid::input::image_decode::{Decoded, depth_from_file};
use limpid::input::open;
use limpid::sensor::{DepthSamples, RgbdFrame};
use prop::collection::vec;
use proptest::prelude::*;

use super::real::config;
use crate::support::data_dir;

/// An image of 3x2 pixels with these channels.
fn file(encoding: Encoding, channels: Vec<(&str, FlatSamples)>) -> Vec<u8> {
    let channels = channels.into_iter().map(|(name, samples)| AnyChannel::new(name, samples)).collect();
    let layer = Layer::new((3, 2), LayerAttributes::default(), encoding, AnyChannels::sort(channels));
    let mut bytes = Cursor::new(Vec::new());
    Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

fn metres(decoded: Decoded<DepthSamples>) -> Vec<f32> {
    assert_eq!((decoded.width, decoded.height), (3, 2));
    match decoded.samples {
        DepthSamples::Metres(samples) => samples,
        DepthSamples::Integer { .. } => panic!("EXR depth is in metres"),
    }
}

#[test]
fn depth_comes_from_the_channel_that_holds_it() {
    let floats = FlatSamples::F32(vec![1.5, 0.0, 2.25, 0.7, 1e-3, 60.0]);
    let other = FlatSamples::F32(vec![9.0; 6]);
    for encoding in [Encoding::UNCOMPRESSED, Encoding::FAST_LOSSLESS, Encoding::SMALL_LOSSLESS] {
        let alone = file(encoding, vec![("Y", floats.clone())]);
        let among = file(encoding, vec![("A", other.clone()), ("Z", floats.clone()), ("R", other.clone())]);
        for bytes in [alone, among] {
            let found = metres(depth_from_file(&bytes, 0.001).unwrap());
            assert_eq!(found, [1.5, 0.0, 2.25, 0.7, 1e-3, 60.0]);
        }
    }
    let halves = FlatSamples::F16([1.5, 0.0, 2.25, 4.0, f32::NAN, 0.25].map(f16::from_f32).to_vec());
    let alike = ["B", "G", "R"].map(|name| (name, halves.clone())).to_vec();
    let found = metres(depth_from_file(&file(Encoding::SMALL_LOSSLESS, alike), 0.001).unwrap());
    assert_eq!([found[0], found[1], found[2], found[3], found[5]], [1.5, 0.0, 2.25, 4.0, 0.25]);
    assert!(found[4].is_nan());
}

#[test]
fn exr_files_that_cannot_be_read_say_why() {
    let floats = FlatSamples::F32(vec![1.0; 6]);
    let whole = file(Encoding::UNCOMPRESSED, vec![("Y", floats.clone()), ("A", floats.clone())]);
    let error = |bytes: &[u8]| depth_from_file(bytes, 0.001).unwrap_err().to_string();
    assert!(error(&file(Encoding::UNCOMPRESSED, vec![("mask", floats)])).contains("no channel Y"));
    for cut in 4..whole.len() {
        assert!(error(&whole[..cut]).contains("EXR depth image"), "cut at {cut}");
    }
    // xMax and yMax of the data window, after the attribute's name, type and size and two zeros.
    let window = whole.windows(10).position(|bytes| bytes == b"dataWindow").unwrap();
    let corner = window + b"dataWindow\0box2i\0".len() + 4 + 8;
    // Without the number of chunks, which would contradict another size, as files of one layer may be.
    let count = whole.windows(10).position(|bytes| bytes == b"chunkCount").unwrap();
    for (last, part) in [
        ([8192, 1], "8193x2, more than 8192 pixels a side"),
        ([1, 1 << 29], "pixels a side"),
        ([8191, 8191], "512 MiB"),
        ([1, i32::MAX], "invalid"),
    ] {
        let mut huge = whole.clone();
        huge[count] = b'x';
        huge[corner..corner + 8].copy_from_slice(&last.map(i32::to_le_bytes).concat());
        assert!(error(&huge).contains(part), "{last:?}: {}", error(&huge));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn exr_files_with_changed_bytes_do_not_panic(
        changes in vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        packed in any::<bool>(),
    ) {
        let encoding = if packed { Encoding::SMALL_LOSSLESS } else { Encoding::UNCOMPRESSED };
        let mut bytes = file(encoding, vec![("Y", FlatSamples::F32(vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0]))]);
        for (at, value) in changes {
            // What is no EXR file is not read as one.
            let at = 4 + at.index(bytes.len() - 4);
            bytes[at] = value;
        }
        if let Ok(depth) = depth_from_file(&bytes, 0.001) {
            prop_assert_eq!(depth.samples.len(), depth.width as usize * depth.height as usize);
        }
    }
}

fn bottles(depth_file: &str) -> Option<RgbdFrame> {
    let path = data_dir("rgbd/cleargrasp-d435")?;
    let config = Config { depth_file: depth_file.into(), ..config("cleargrasp.yaml") };
    open(&path, &config).unwrap().next_frame().unwrap()
}

fn samples(frame: &RgbdFrame) -> &[f32] {
    match &frame.depth.samples {
        DepthSamples::Metres(samples) => samples,
        DepthSamples::Integer { .. } => panic!("EXR depth is in metres"),
    }
}

/// Number of zeros, number of NaN, and the sum of the others weighted by column, counted from 1.
fn figures(frame: &RgbdFrame) -> (usize, usize, f64) {
    let samples = samples(frame);
    let zeros = samples.iter().filter(|&&depth_m| depth_m == 0.0).count();
    let gaps = samples.iter().filter(|depth_m| depth_m.is_nan()).count();
    let columns = (1..=1280_u32).cycle().zip(samples);
    let sum =
        columns.filter(|(_, depth_m)| !depth_m.is_nan()).map(|(x, &m)| f64::from(x) * f64::from(m)).sum();
    (zeros, gaps, sum)
}

#[test]
fn the_bottles_stand_on_the_stated_table() {
    let Some(frame) = bottles("000000080-transparent-depth-img.exr") else { return };
    let camera = frame.depth.camera;
    assert_eq!(
        (camera.width, camera.height, frame.color.as_ref().unwrap().rgb.len()),
        (1280, 720, 2_764_800)
    );
    let pose = frame.pose.unwrap();
    let map_from_camera = pose.map_from_base.then(pose.base_from_camera);
    let height_m = |x: u32, y: u32| {
        let depth_m = f64::from(samples(&frame)[(y * 1280 + x) as usize]);
        let [ray_x, ray_y] = camera.ray(x.into(), y.into()).unwrap();
        map_from_camera.transform_point(DVec3::new(ray_x, ray_y, 1.0) * depth_m).z
    };
    let measured = |&(x, y): &(u32, u32)| samples(&frame)[(y * 1280 + x) as usize] > 0.0;
    let grid: Vec<_> = (0..720).step_by(8).flat_map(|y| (0..1280).step_by(8).map(move |x| (x, y))).collect();
    let all: Vec<f64> = grid.iter().filter(|&at| measured(at)).map(|&(x, y)| height_m(x, y)).collect();
    let on_table = all.iter().filter(|height_m| height_m.abs() < 0.008).count();
    assert!(on_table * 3 > all.len() * 2, "{on_table} of {} lie on the table", all.len());
    assert!(all.iter().all(|height_m| (-0.05..0.3).contains(height_m)), "nothing is far from it");
}

#[test]
fn depth_is_what_the_reference_reader_finds() {
    // From the Python package OpenEXR 3.5: counts exact, sums of half floats in f64.
    for (name, expected) in [
        ("000000080-transparent-depth-img.exr", (125_275, 0, 328_216_847.584_228_5)),
        ("000000080-opaque-depth-img.exr", (0, 81_078, 342_619_934.840_942_1)),
    ] {
        let Some(frame) = bottles(name) else { return };
        let found = figures(&frame);
        assert_eq!((found.0, found.1), (expected.0, expected.1), "{name}");
        assert!((found.2 - expected.2).abs() < 1e-3, "{name}: {} against {}", found.2, expected.2);
    }
}
