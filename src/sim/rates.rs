//! How far measured depth is from the truth: holes, spikes, error (spec 1 §2 and §6).

use super::frame::SimFrame;

/// Depth taken as measured, metres (spec 1 §3).
pub const DEPTH_RANGE_M: [f64; 2] = [0.17, 10.0];

/// An error above this share of the true depth is a spike (spec 1 §2).
pub const SPIKE_SHARE: f64 = 0.1;

/// Counts over the pixels of one frame or many.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Rates {
    /// Pixels.
    pub pixels: u64,
    /// Pixels with depth in [`DEPTH_RANGE_M`].
    pub valid: u64,
    /// Valid pixels whose true depth is known; spikes and error are counted over them.
    pub compared: u64,
    /// Of these, those that are wrong by more than [`SPIKE_SHARE`] of the true depth.
    pub spikes: u64,
    /// Sum of squared errors, square metres.
    pub squared_error_m2: f64,
}

impl Rates {
    /// Of one frame.
    pub fn of(frame: &SimFrame) -> Self {
        let mut rates = Self { pixels: frame.depth_mm.len() as u64, ..Self::default() };
        for (&millimetres, &truth) in frame.depth_mm.iter().zip(&frame.true_depth_m) {
            let (depth_m, truth_m) = (f64::from(millimetres) * 1e-3, f64::from(truth));
            if !(DEPTH_RANGE_M[0]..=DEPTH_RANGE_M[1]).contains(&depth_m) {
                continue;
            }
            rates.valid += 1;
            if truth_m > 0.0 {
                let error_m = depth_m - truth_m;
                rates.compared += 1;
                rates.spikes += u64::from(error_m.abs() > SPIKE_SHARE * truth_m);
                rates.squared_error_m2 += error_m * error_m;
            }
        }
        rates
    }

    /// Adds the counts of another frame.
    pub fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.valid += other.valid;
        self.compared += other.compared;
        self.spikes += other.spikes;
        self.squared_error_m2 += other.squared_error_m2;
    }

    /// Share of all pixels without depth in range.
    pub fn hole_rate(&self) -> f64 {
        share(self.pixels - self.valid, self.pixels)
    }

    /// Share of the compared pixels that are spikes.
    pub fn spike_rate(&self) -> f64 {
        share(self.spikes, self.compared)
    }

    /// Root mean square error of the compared pixels, metres.
    pub fn rmse_m(&self) -> f64 {
        (self.squared_error_m2 / float(self.compared.max(1))).sqrt()
    }
}

fn share(part: u64, whole: u64) -> f64 {
    float(part) / float(whole.max(1))
}

fn float(count: u64) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "pixels of any recording fit in 53 bits")]
    let float = count as f64;
    float
}

impl std::fmt::Display for Rates {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (holes, spikes) = (100.0 * self.hole_rate(), 100.0 * self.spike_rate());
        write!(f, "holes {holes:5.1} %  spikes {spikes:5.1} %  RMSE {:.3} m", self.rmse_m())
    }
}
