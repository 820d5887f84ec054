//! Depth against the truth: holes, spikes, error among the pixels that a method trusts (spec 1 §2, §6).

use serde::{Deserialize, Serialize};

use crate::offline::eval::share;
use crate::sensor::{DepthSamples, RgbdFrame};
use crate::sim::rates::{DEPTH_RANGE_M, SPIKE_SHARE};

/// Deviation of the disparity that stereo noise is taken to have, pixels (spec 1 §2).
const DISPARITY_NOISE_PX: f64 = 0.08;

/// Distance of a D435's imagers, metres.
const BASELINE_M: f64 = 0.05;

/// delta(d) of spec 1 §2: how far depth may lie from `depth_m` and still be right, metres. 2 % of it, or two deviations of
/// the noise of a D435 whose focal length is `focal_px`, whichever is more.
pub fn tolerance_m(depth_m: f64, focal_px: f64) -> f64 {
    let deviation_m = DISPARITY_NOISE_PX * depth_m * depth_m / (focal_px * BASELINE_M);
    (0.02 * depth_m).max(2.0 * deviation_m)
}

/// Measured depth of a frame, metres, 0 where there is none in the sensor's range (0.17 to 10 m).
pub fn measured_m(frame: &RgbdFrame) -> Vec<f32> {
    let within = |depth_m: f32| if is_measured(depth_m) { depth_m } else { 0.0 };
    match &frame.depth.samples {
        DepthSamples::Metres(samples) => samples.iter().copied().map(within).collect(),
        DepthSamples::Integer { raw, unit_m } => {
            let metres = |&count: &u16| within(crate::stage::single(f64::from(count) * unit_m));
            raw.iter().map(metres).collect()
        }
    }
}

/// Whether depth is in the sensor's range; NaN is not.
pub fn is_measured(depth_m: f32) -> bool {
    (DEPTH_RANGE_M[0]..=DEPTH_RANGE_M[1]).contains(&f64::from(depth_m))
}

/// Counts over the pixels of one frame or many, for one method.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct DepthTally {
    /// Pixels.
    pub pixels: u64,
    /// Pixels that the sensor measured.
    pub measured: u64,
    /// Of these, pixels that the method does not trust.
    pub given_up: u64,
    /// Pixels that the method trusts: with depth in range and a weight above tau.
    pub trusted: u64,
    /// Of these, pixels whose true depth is known.
    pub compared: u64,
    /// Of these, pixels that are wrong by more than a tenth of the true depth.
    pub spikes: u64,
    /// Sum of their squared errors, square metres.
    pub squared_error_m2: f64,
}

impl DepthTally {
    /// Adds a frame: what the sensor measured, what the method makes of it (depth and weight), and the truth, all pixel by
    /// pixel; depth 0 is none.
    pub fn observe(&mut self, measured_m: &[f32], depth_m: &[f32], weight: &[f32], tau: f32, true_m: &[f32]) {
        let method = depth_m.iter().zip(weight);
        for ((&measured, (&depth, &weight)), &truth) in measured_m.iter().zip(method).zip(true_m) {
            let trusted = is_measured(depth) && weight > tau;
            self.pixels += 1;
            self.measured += u64::from(measured > 0.0);
            self.given_up += u64::from(measured > 0.0 && !trusted);
            self.trusted += u64::from(trusted);
            if trusted && truth > 0.0 {
                let error_m = f64::from(depth) - f64::from(truth);
                self.compared += 1;
                self.spikes += u64::from(error_m.abs() > SPIKE_SHARE * f64::from(truth));
                self.squared_error_m2 += error_m * error_m;
            }
        }
    }

    /// Adds the counts of others.
    pub fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.measured += other.measured;
        self.given_up += other.given_up;
        self.trusted += other.trusted;
        self.compared += other.compared;
        self.spikes += other.spikes;
        self.squared_error_m2 += other.squared_error_m2;
    }

    /// Share of all pixels without trusted depth.
    pub fn hole_rate(&self) -> Option<f64> {
        share(self.pixels - self.trusted, self.pixels)
    }

    /// Share of the trusted pixels that are spikes.
    pub fn spike_rate(&self) -> Option<f64> {
        share(self.spikes, self.compared)
    }

    /// Root mean square error of the trusted pixels, metres.
    pub fn rmse_m(&self) -> Option<f64> {
        #[expect(clippy::cast_precision_loss, reason = "pixels of any evaluation fit in 53 bits")]
        let compared = self.compared as f64;
        (self.compared > 0).then(|| (self.squared_error_m2 / compared).sqrt())
    }

    /// Share of the measured pixels that the method does not trust.
    pub fn given_up_share(&self) -> Option<f64> {
        share(self.given_up, self.measured)
    }
}
