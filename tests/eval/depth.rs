//! Holes, spikes, error, tolerance, cheap predictors.

use limpid::offline::eval::DepthTally;
use limpid::offline::eval::depth::{measured_m, tolerance_m};
use limpid::offline::eval::predictors::Predictor;
use limpid::sensor::DepthSamples;

use crate::support::scene::{frame, small_camera};

#[test]
fn counts_by_hand() {
    //                hole  good  spike, not trusted  beyond 10 m  no truth  off by 0.1
    let measured = [0.0_f32, 2.0, 3.0, 0.0, 1.0, 2.1];
    let depth = [0.0_f32, 2.0, 3.0, 12.0, 1.0, 2.1];
    let weight = [0.0_f32, 1.0, 0.3, 1.0, 0.9, 0.31];
    let truth = [1.0_f32, 2.0, 2.0, 2.0, 0.0, 2.0];
    let mut gated = DepthTally::default();
    gated.observe(&measured, &depth, &weight, 0.3, &truth);
    assert_eq!((gated.pixels, gated.measured, gated.given_up, gated.trusted), (6, 4, 1, 3));
    assert_eq!((gated.compared, gated.spikes), (2, 0));
    assert_eq!(gated.hole_rate(), Some(0.5));
    assert_eq!(gated.given_up_share(), Some(0.25));
    assert!((gated.rmse_m().unwrap() - (0.01_f64 / 2.0).sqrt()).abs() < 1e-6);
    let mut all = DepthTally::default();
    all.observe(&measured, &depth, &[1.0; 6], 0.3, &truth);
    assert_eq!((all.trusted, all.compared, all.spikes, all.given_up), (4, 3, 1, 0));
    assert_eq!(all.spike_rate(), Some(1.0 / 3.0));
    assert!((all.rmse_m().unwrap() - ((1.0_f64 + 0.01) / 3.0).sqrt()).abs() < 1e-6);
    gated.add(&all);
    assert_eq!((gated.pixels, gated.trusted, gated.spikes), (12, 7, 1));
    assert_eq!(DepthTally::default().hole_rate(), None);
    assert_eq!(DepthTally::default().rmse_m(), None);
}

#[test]
fn a_spike_is_more_than_a_tenth() {
    let spikes = |depth: f32| {
        let mut tally = DepthTally::default();
        tally.observe(&[depth], &[depth], &[1.0], 0.3, &[4.0]);
        tally.spikes
    };
    assert_eq!([3.59, 3.61, 4.39, 4.41].map(spikes), [1, 0, 0, 1]);
}

#[test]
fn tolerance_is_two_percent_near_and_two_deviations_far() {
    // 2 * 0.08 px * d^2 / (425 px * 0.05 m) = 0.02 d at d = 2.656 m.
    assert!((tolerance_m(1.0, 425.0) - 0.02).abs() < 1e-12);
    assert!((tolerance_m(2.65, 425.0) - 0.053).abs() < 1e-12);
    assert!((tolerance_m(5.0, 425.0) - 2.0 * 0.08 * 25.0 / 21.25).abs() < 1e-12);
}

#[test]
fn measured_depth_is_in_the_sensors_range() {
    let mut samples = vec![1.0_f32; 160 * 120];
    samples[..7].copy_from_slice(&[f32::NAN, f32::INFINITY, -1.0, 0.0, 0.169, 10.01, 10.0]);
    let metres = measured_m(&frame(0, small_camera(), None, DepthSamples::Metres(samples)));
    assert_eq!(metres[..8], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 10.0, 1.0]);
    let mut raw = vec![1500_u16; 160 * 120];
    raw[..3].copy_from_slice(&[0, 100, 65535]);
    let counts = DepthSamples::Integer { raw, unit_m: 0.001 };
    let metres = measured_m(&frame(0, small_camera(), None, counts));
    assert_eq!(metres[..4], [0.0, 0.0, 0.0, 1.5]);
}

/// 5 x 4 pixels with one hole and one step.
const IMAGE: [f32; 20] = [
    1.0, 1.0, 1.0, 3.0, 3.0, //
    1.0, 1.0, 1.0, 3.0, 3.0, //
    1.0, 0.0, 1.0, 3.0, 3.0, //
    1.0, 1.0, 1.0, 3.0, 3.5,
];

#[test]
fn predictors_by_hand() {
    let score = |predictor: Predictor, x: usize, y: usize| predictor.scores(&IMAGE, 5)[y * 5 + x];
    assert_eq!(score(Predictor::Depth, 3, 0), 3.0);
    // Across a hole there is no difference.
    assert_eq!(
        [(0, 2), (2, 0), (3, 1), (4, 0)].map(|(x, y)| score(Predictor::Gradient, x, y)),
        [0.0, 2.0, 2.0, 0.0]
    );
    assert_eq!(score(Predictor::Gradient, 4, 3), 0.5);
    // Around (0, 0): 3 x 3 pixels, all 1 but for one hole; around (2, 1): the whole image.
    assert_eq!(score(Predictor::Variance, 0, 0), 0.0);
    let valid: Vec<f64> = IMAGE.iter().filter(|&&d| d > 0.0).map(|&d| f64::from(d)).collect();
    let mean = valid.iter().sum::<f64>() / 19.0;
    let variance = valid.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 19.0;
    assert!((f64::from(score(Predictor::Variance, 2, 1)) - variance).abs() < 1e-6);
    // From (1, 2): straight 1, aside sqrt 2.
    let near = |x, y| score(Predictor::HoleNearness, x, y);
    assert_eq!([near(0, 2), near(1, 1), near(3, 2)], [1.0, 1.0, 0.5]);
    assert!((near(4, 0) - 1.0 / (2.0 * std::f32::consts::SQRT_2 + 1.0)).abs() < 1e-6);
    assert_eq!(Predictor::HoleNearness.scores(&[1.0; 6], 3), [0.0; 6], "no hole anywhere");
}

#[test]
fn predictors_take_any_size() {
    for (width, height) in [(1, 1), (1, 7), (7, 1), (2, 2), (3, 5)] {
        for predictor in Predictor::ALL {
            let scores = predictor.scores(&vec![1.0; width * height], width);
            assert_eq!(scores.len(), width * height, "{predictor:?}");
            assert!(scores.iter().all(|score| score.is_finite()), "{predictor:?}");
        }
    }
    assert!(Predictor::ALL.iter().all(|predictor| predictor.scores(&[], 0).is_empty()));
}
