//! Reliability per pixel: constant, or the sensor's confidence.

use limpid::gpu::{Invocations, ShaderSource};
use limpid::stage::weigh::{CONFIDENCE, CONSTANT, WeighParams};

use crate::reference;
use crate::support::compare::{EXACT, assert_close};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

fn padded(values: &[f32]) -> Vec<f32> {
    let mut padded = values.to_vec();
    padded.resize(values.len().next_multiple_of(4), 0.0);
    padded
}

fn fragment(depth_m: &[f32], confidence: Option<&[f32]>) -> (Fragment, ShaderSource, u32) {
    let depth = padded(depth_m);
    let words = (depth.len() / 4) as u32;
    let fragment = Fragment::new()
        .params("weigh_params", &WeighParams { words })
        .input("depth_m", &depth)
        .output("reliability", depth.len());
    match confidence {
        Some(confidence) => (fragment.input("confidence_raw", &padded(confidence)), CONFIDENCE, words),
        None => (fragment, CONSTANT, words),
    }
}

fn weigh(depth_m: &[f32], confidence: Option<&[f32]>) -> Vec<f32> {
    let (fragment, source, words) = fragment(depth_m, confidence);
    let mut weights = fragment.run(source, Invocations::line(words)).floats("reliability");
    weights.truncate(depth_m.len());
    weights
}

#[test]
fn truth() {
    if skipped() {
        return;
    }
    let depth = [0.0, 0.2, 1.0, 5.0, 0.0];
    assert_close("constant", &weigh(&depth, None), &[0.0_f32, 1.0, 1.0, 1.0, 0.0], EXACT);
    let confidence = [0.9, 0.0, 0.25, 1.0, 1.0];
    assert_close("confidence", &weigh(&depth, Some(&confidence)), &[0.0_f32, 0.0, 0.25, 1.0, 0.0], EXACT);
}

#[test]
fn twin() {
    if skipped() {
        return;
    }
    let mut random = Random(5);
    let depth: Vec<f32> = (0..999).map(|_| if random.chance(0.3) { 0.0 } else { random.unit() }).collect();
    let confidence: Vec<f32> = (0..999).map(|_| random.unit() * 1.5 - 0.25).collect();
    for confidence in [None, Some(confidence.as_slice())] {
        let want = reference::weigh::weigh(&depth, confidence);
        assert_close("weights", &weigh(&depth, confidence), &want, EXACT);
    }
}

#[test]
fn edge_sizes() {
    if skipped() {
        return;
    }
    for confidence in [None, Some([0.5].as_slice())] {
        let (fragment, source, _) = fragment(&[1.0], confidence);
        fragment.refuses_nothing(source);
    }
    for count in [1, 3, 4, 5, 63 * 4, 64 * 4, 65 * 4, 257] {
        assert_close("constant", &weigh(&vec![2.0; count], None), &vec![1.0_f32; count], EXACT);
        let half = vec![0.5_f32; count];
        assert_close("confidence", &weigh(&vec![2.0; count], Some(&half)), &half, EXACT);
    }
}

#[test]
fn poison_is_not_trusted() {
    if skipped() {
        return;
    }
    let poison = [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, -0.0, 1e30, 1.0];
    let weights = weigh(&[1.0; 9], Some(&poison));
    assert_close("confidence", &weights, &[0.0_f32, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0], EXACT);
    let depths = [-1.0, f32::NEG_INFINITY, f32::NAN, 0.0, f32::MAX];
    assert_close("depth", &weigh(&depths, None), &[0.0_f32, 0.0, 0.0, 0.0, 1.0], EXACT);
}
