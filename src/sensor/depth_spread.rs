//! How far the depth of a camera reaches, from samples of its images.

use crate::sensor::DepthSamples;

/// Most samples taken of an image.
const MOST_SAMPLES: usize = 4096;

/// Steps of the histogram in a factor of ten.
const STEPS_A_DECADE: f64 = 20.0;

/// Depth of the first step, metres, and their number: to 10 km.
const FIRST_M: f64 = 1e-5;
const STEPS: usize = 180;

/// Counts of depths in steps that grow with depth (a factor of 1.12); holes do not count.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DepthSpread {
    counts: [u64; STEPS],
}

impl Default for DepthSpread {
    fn default() -> Self {
        Self { counts: [0; STEPS] }
    }
}

impl DepthSpread {
    /// Takes in an image, some thousand pixels of it.
    pub fn add(&mut self, samples: &DepthSamples) {
        let stride = (samples.len() / MOST_SAMPLES).max(1);
        match samples {
            DepthSamples::Integer { raw, unit_m } => {
                let measured = raw.iter().step_by(stride).filter(|&&count| count > 0 && count < u16::MAX);
                measured.for_each(|&count| self.count_in(f64::from(count) * unit_m));
            }
            DepthSamples::Metres(depths) => {
                let measured =
                    depths.iter().step_by(stride).filter(|depth| depth.is_finite() && **depth > 0.0);
                measured.for_each(|&depth| self.count_in(f64::from(depth)));
            }
        }
    }

    fn count_in(&mut self, depth_m: f64) {
        self.counts[step_of(depth_m)] += 1;
    }

    /// Depths counted.
    pub fn count(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// The median, metres, to a twentieth; `None` where nothing was counted.
    pub fn median_m(&self) -> Option<f64> {
        let half = self.count().div_ceil(2);
        let mut below = 0;
        let step = self.counts.iter().position(|count| {
            below += count;
            below >= half && half > 0
        })?;
        #[expect(clippy::cast_precision_loss, reason = "180 steps")]
        let middle = step as f64 + 0.5;
        Some(FIRST_M * 10_f64.powf(middle / STEPS_A_DECADE))
    }

    /// Share of the depths that lie in steps beyond a limit, metres; 0 where nothing was counted.
    pub fn share_beyond(&self, limit_m: f64) -> f64 {
        let beyond: u64 = self.counts[step_of(limit_m) + 1..].iter().sum();
        #[expect(clippy::cast_precision_loss, reason = "a share")]
        let share = beyond as f64 / self.count().max(1) as f64;
        share
    }
}

fn step_of(depth_m: f64) -> usize {
    #[expect(clippy::cast_precision_loss, reason = "180 steps")]
    let step = ((depth_m / FIRST_M).log10() * STEPS_A_DECADE).floor().clamp(0.0, STEPS as f64 - 2.0);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the steps")]
    let step = step as usize;
    step
}
