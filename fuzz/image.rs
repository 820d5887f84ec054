//! Any bytes as images: every encoding and every packed form. Errors or as many pixels as the image says.
#![no_main]

use libfuzzer_sys::fuzz_target;
use limpid::input::image_decode::{RawImage, color_from_file, depth_from_compressed, depth_from_file};

const RAW: [&str; 32] = [
    "rgb8", "bgr8", "rgba8", "bgra8", "mono8", "8UC1", "8UC3", "8UC4", "yuv422", "uyvy", "yuv422_yuy2", "yuyv",
    "bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8", "bayer_rggb16", "bayer_bggr16", "bayer_gbrg16",
    "bayer_grbg16", "nv12", "nv21", "nv24", "16UC1", "mono16", "32FC1", "rgb16", "bgr16", "rgba16", "bgra16", "yuv420", "",
];

const PACKED: [&str; 6] = [
    "16UC1; compressedDepth rvl",
    "32FC1; compressedDepth rvl",
    "16UC1; compressedDepth png",
    "32FC1; compressedDepth png",
    "16UC1; png compressed ",
    "",
];

fuzz_target!(|bytes: &[u8]| {
    let [kind, width, height, step, order, data @ ..] = bytes else { return };
    let packed = depth_from_compressed(PACKED[usize::from(*kind) % PACKED.len()], data, 0.001);
    for depth in [packed, depth_from_file(data, 0.001)].into_iter().flatten() {
        assert_eq!(depth.samples.len(), depth.width as usize * depth.height as usize);
    }
    if let Ok(color) = color_from_file(data) {
        assert_eq!(color.samples.len(), 3 * color.width as usize * color.height as usize);
    }
    let [width, height, step] = [*width, *height, *step].map(u32::from);
    let raw = RawImage {
        width,
        height,
        step: 4 * step,
        encoding: RAW[usize::from(*kind) % RAW.len()],
        big_endian: order % 2 == 1,
        data,
    };
    let pixels = width as usize * height as usize;
    assert!(raw.color().is_ok_and(|image| image.samples.len() == 3 * pixels) || raw.color().is_err());
    assert!(raw.depth(0.001).is_ok_and(|image| image.samples.len() == pixels) || raw.depth(0.001).is_err());
    assert!(raw.confidence().is_ok_and(|image| image.samples.len() == pixels) || raw.confidence().is_err());
});
