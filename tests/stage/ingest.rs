//! Raw depth to metres, range gating.

use bytemuck::cast_slice;
use limpid::config::{Config, Method};
use limpid::gpu::Invocations;
use limpid::sensor::DepthSamples;
use limpid::stage::camera::ingest::{INGEST, IngestParams};

use crate::reference;
use crate::support::compare::{EXACT, Tolerance, assert_close};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

const PRODUCT: Tolerance = Tolerance {
    absolute: 8e-6,
    reason: "count and unit are rounded to f32, then their product: 1.5 units in the last place at 65 m",
};

fn with(method: Method) -> Config {
    Config { method, ..Config::default() }
}

fn fragment(config: &Config, samples: &DepthSamples) -> (Fragment, u32) {
    let (mut bytes, unit_m, pixels_per_word) = match samples {
        DepthSamples::Integer { raw, unit_m } => (cast_slice::<u16, u8>(raw).to_vec(), Some(*unit_m), 8),
        DepthSamples::Metres(metres) => (cast_slice::<f32, u8>(metres).to_vec(), None, 4),
    };
    let words = samples.len().div_ceil(pixels_per_word);
    bytes.resize(words * 16, 0);
    let params = IngestParams::new(config, words as u32, unit_m);
    let fragment = Fragment::new()
        .params("ingest_params", &params)
        .constants(&[("floats", unit_m.is_none())])
        .input("depth_raw", &bytes)
        .output("depth_m", words * pixels_per_word)
        .output("reliability", words * pixels_per_word);
    (fragment, words as u32)
}

fn ingest(config: &Config, samples: &DepthSamples) -> Vec<f32> {
    let (fragment, words) = fragment(config, samples);
    let out = fragment.run(INGEST, Invocations::line(words));
    let mut depth = out.floats("depth_m");
    let weights: Vec<f32> = depth.iter().map(|&d| if d > 0.0 { 1.0 } else { 0.0 }).collect();
    assert_close("weight 1 where there is depth", &out.floats("reliability"), &weights, EXACT);
    let padding = depth.split_off(samples.len());
    assert!(padding.iter().all(|&d| d == 0.0), "padding is no depth");
    depth
}

fn millimetres(raw: &[u16]) -> DepthSamples {
    DepthSamples::Integer { raw: raw.to_vec(), unit_m: 0.001 }
}

#[test]
fn truth_limits_are_part_of_the_range() {
    if skipped() {
        return;
    }
    let samples = millimetres(&[0, 1, 169, 170, 171, 4999, 5000, 5001, 65535]);
    let range = ingest(&with(Method::Range), &samples);
    assert_close("range", &range, &[0.0_f32, 0.0, 0.0, 0.17, 0.171, 4.999, 5.0, 0.0, 0.0], PRODUCT);
    let naive = ingest(&with(Method::Naive), &samples);
    assert_close("naive", &naive, &[0.0, 0.001, 0.169, 0.17, 0.171, 4.999, 5.0, 5.001, 0.0_f32], PRODUCT);
    let floats = ingest(&with(Method::Range), &DepthSamples::Metres(vec![0.17, 5.0, 0.1699, 5.0001]));
    assert_close("floats", &floats, &[0.17_f32, 5.0, 0.0, 0.0], EXACT);
}

#[test]
fn twin_on_random_counts_and_metres() {
    if skipped() {
        return;
    }
    let mut random = Random(1);
    let raw: Vec<u16> = (0..1001).map(|_| random.below(65536) as u16 >> random.below(8)).collect();
    let metres: Vec<f32> = (0..1001).map(|_| random.unit() * 7.0).collect();
    for config in [Method::Range, Method::Naive, Method::Median, Method::Temporal].map(with) {
        for unit_m in [0.001, 0.000_1, 0.25] {
            let samples = DepthSamples::Integer { raw: raw.clone(), unit_m };
            let want = reference::ingest::ingest(&config, &samples);
            let absolute = if unit_m > 0.1 { PRODUCT.absolute * 1000.0 } else { PRODUCT.absolute };
            let tolerance = Tolerance { absolute, ..PRODUCT };
            assert_close("counts", &ingest(&config, &samples), &want, tolerance);
        }
        let samples = DepthSamples::Metres(metres.clone());
        let want = reference::ingest::ingest(&config, &samples);
        assert_close("metres", &ingest(&config, &samples), &want, EXACT);
    }
}

#[test]
fn edge_sizes() {
    if skipped() {
        return;
    }
    fragment(&with(Method::Naive), &millimetres(&[1])).0.refuses_nothing(INGEST);
    for count in [1, 7, 8, 9, 63 * 8, 64 * 8 + 1, 65 * 8, 511] {
        let raw: Vec<u16> = (0..count).map(|i| 200 + i).collect();
        let want: Vec<f32> = raw.iter().map(|&r| f32::from(r) * 0.001).collect();
        assert_close("counts", &ingest(&with(Method::Range), &millimetres(&raw)), &want, EXACT);
        let samples = DepthSamples::Metres(want.clone());
        assert_close("metres", &ingest(&with(Method::Range), &samples), &want, EXACT);
    }
}

#[test]
fn poison_is_no_depth() {
    if skipped() {
        return;
    }
    let poison = [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -0.0, -1.0, f32::MIN, 3.0];
    for method in [Method::Naive, Method::Range] {
        let depth = ingest(&with(method), &DepthSamples::Metres(poison.to_vec()));
        assert_close("poison", &depth, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.0_f32], EXACT);
    }
    let huge = DepthSamples::Metres(vec![f32::MAX, 1e30, 1e-30]);
    assert_close("huge, naive", &ingest(&with(Method::Naive), &huge), &[f32::MAX, 1e30, 1e-30], EXACT);
    assert_close("huge, range", &ingest(&with(Method::Range), &huge), &[0.0_f32; 3], EXACT);
}

#[test]
fn a_unit_beyond_the_range_leaves_no_depth() {
    if skipped() {
        return;
    }
    let raw = vec![0, 1, 2, 40_000, 65_534, 65_535];
    let coarse = DepthSamples::Integer { raw: raw.clone(), unit_m: 6.0 };
    assert_close("6 m a count", &ingest(&with(Method::Range), &coarse), &[0.0_f32; 6], EXACT);
    let fine = DepthSamples::Integer { raw, unit_m: 1e-6 };
    assert_close("1 um a count", &ingest(&with(Method::Range), &fine), &[0.0_f32; 6], EXACT);
}
