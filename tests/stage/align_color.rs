//! Colour that lies on the depth grid.

use limpid::gpu::Invocations;
use limpid::stage::camera::align_color::{ALIGN_COLOR, AlignColorParams};

use crate::reference::align_color::align_color;
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

fn fragment(rgb: &[u8], present: u32) -> (Fragment, u32) {
    let words = (rgb.len() / 3).div_ceil(4);
    let mut padded = rgb.to_vec();
    padded.resize(12 * words, 0xee);
    let words = words as u32;
    let fragment = Fragment::new()
        .params("align_color_params", &AlignColorParams { words, present, pad0: 0, pad1: 0 })
        .input("color_raw", &padded)
        .output("color", 4 * words as usize);
    (fragment, words)
}

fn run(rgb: &[u8], present: u32) -> Vec<u32> {
    let (fragment, words) = fragment(rgb, present);
    let out = fragment.run(ALIGN_COLOR, Invocations::line(words));
    out.words("color")[..rgb.len() / 3].to_vec()
}

fn noise(pixels: usize) -> Vec<u8> {
    let mut random = Random(7);
    (0..3 * pixels).map(|_| random.next() as u8).collect()
}

#[test]
fn truth_bytes_by_hand() {
    if skipped() {
        return;
    }
    let rgb: Vec<u8> = (1..=15).collect();
    let want = [0xff03_0201, 0xff06_0504, 0xff09_0807, 0xff0c_0b0a, 0xff0f_0e0d];
    assert_eq!(run(&rgb, 1), want);
    assert_eq!(run(&rgb, 0), [0; 5]);
}

#[test]
fn twin_at_edge_sizes() {
    if skipped() {
        return;
    }
    fragment(&[1, 2, 3], 1).0.refuses_nothing(ALIGN_COLOR);
    for pixels in [1, 3, 4, 5, 255, 256, 257, 1021] {
        let rgb = noise(pixels);
        assert_eq!(run(&rgb, 1), align_color(&rgb, true), "{pixels} pixels");
    }
}

#[test]
fn control_another_byte_is_another_pixel() {
    if skipped() {
        return;
    }
    let rgb = noise(64);
    for byte in [0, 1, 2, 3, 100, 191] {
        let mut other = rgb.clone();
        other[byte] ^= 1;
        let differing = run(&rgb, 1).iter().zip(align_color(&other, true)).filter(|(a, b)| **a != *b).count();
        assert_eq!(differing, 1, "byte {byte}");
    }
}
