//! Reliability per pixel from the sensor's confidence.

use limpid::gpu::Invocations;
use limpid::stage::camera::weigh::{WEIGH, WeighParams};

use crate::reference;
use crate::support::compare::{EXACT, assert_close};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

fn padded(values: &[f32]) -> Vec<f32> {
    let mut padded = values.to_vec();
    padded.resize(values.len().next_multiple_of(4), 0.0);
    padded
}

/// The pass after ingest, which leaves weight 1 where there is depth.
fn fragment(depth_m: &[f32], confidence: &[f32]) -> (Fragment, u32) {
    let weights: Vec<f32> = padded(depth_m).iter().map(|&d| if d > 0.0 { 1.0 } else { 0.0 }).collect();
    let words = (weights.len() / 4) as u32;
    let fragment = Fragment::new()
        .params("weigh_params", &WeighParams { words })
        .input("confidence_raw", &padded(confidence))
        .changed("reliability", &weights);
    (fragment, words)
}

fn weigh(depth_m: &[f32], confidence: &[f32]) -> Vec<f32> {
    let (fragment, words) = fragment(depth_m, confidence);
    let mut weights = fragment.run(WEIGH, Invocations::line(words)).floats("reliability");
    weights.truncate(depth_m.len());
    weights
}

#[test]
fn truth() {
    if skipped() {
        return;
    }
    let weights = weigh(&[0.0, 0.2, 1.0, 5.0, 0.0], &[0.9, 0.0, 0.25, 1.0, 1.0]);
    assert_close("confidence", &weights, &[0.0_f32, 0.0, 0.25, 1.0, 0.0], EXACT);
}

#[test]
fn twin() {
    if skipped() {
        return;
    }
    let mut random = Random(5);
    let depth: Vec<f32> = (0..999).map(|_| if random.chance(0.3) { 0.0 } else { random.unit() }).collect();
    let confidence: Vec<f32> = (0..999).map(|_| random.unit() * 1.5 - 0.25).collect();
    let want = reference::weigh::weigh(&depth, &confidence);
    assert_close("weights", &weigh(&depth, &confidence), &want, EXACT);
}

#[test]
fn edge_sizes() {
    if skipped() {
        return;
    }
    fragment(&[1.0], &[0.5]).0.refuses_nothing(WEIGH);
    for count in [1, 3, 4, 5, 63 * 4, 64 * 4, 65 * 4, 257] {
        let half = vec![0.5_f32; count];
        assert_close("confidence", &weigh(&vec![2.0; count], &half), &half, EXACT);
    }
}

#[test]
fn poison_is_not_trusted() {
    if skipped() {
        return;
    }
    let poison = [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, 0.0, -0.0, 1e30, 1.0];
    let weights = weigh(&[1.0; 9], &poison);
    assert_close("confidence", &weights, &[0.0_f32, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0], EXACT);
}
