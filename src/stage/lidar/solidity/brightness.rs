//! How bright a return is within its own scan, whatever the sensor's scale.

use crate::sensor::{Point, Scan};

/// Points that are looked at, at most.
const MOST_POINTS: usize = 8192;
/// Points with an intensity from which a trend says something, and their least share.
const LEAST_POINTS: usize = 64;
const LEAST_SHARE: f64 = 0.5;
/// Least deviation from the trend, in log2 of intensity: with less, intensities are all equal or cut off.
const LEAST_DEVIATION: f64 = 0.05;
/// Slopes that a sensor can have: from a signal that falls with the fourth power of range to one that is compensated too far.
const SLOPES: [f64; 2] = [-4.0, 2.0];

/// log2 of intensity over log2 of range, as least squares have it. Neither a factor nor a power of all intensities changes what
/// [`Trend::contrast`] says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trend {
    /// At 1 m.
    pub at_1m: f64,
    /// Growth with log2 of range.
    pub slope: f64,
    /// Deviation from it; above 0.
    pub deviation: f64,
}

impl Trend {
    /// Of a scan; `None` where its intensities say nothing: there are none, or they are equal, or most are 0 or less.
    pub fn of(scan: &Scan) -> Option<Self> {
        if !scan.columns.intensity {
            return None;
        }
        let stride = scan.points.len().div_ceil(MOST_POINTS).max(1);
        let looked_at = scan.points.len().div_ceil(stride);
        let pairs: Vec<[f64; 2]> = scan.points.iter().step_by(stride).filter_map(logarithms).collect();
        let count = f64::from(u32::try_from(pairs.len()).ok()?);
        if pairs.len() < LEAST_POINTS || count < LEAST_SHARE * f64::from(u32::try_from(looked_at).ok()?) {
            return None;
        }
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| pairs.iter().map(of).sum::<f64>() / count;
        let [x, y] = [mean(&|pair| pair[0]), mean(&|pair| pair[1])];
        let xx = mean(&|pair| (pair[0] - x).powi(2));
        let xy = mean(&|pair| (pair[0] - x) * (pair[1] - y));
        let slope = if xx > 1e-6 { (xy / xx).clamp(SLOPES[0], SLOPES[1]) } else { 0.0 };
        let at_1m = y - slope * x;
        let deviation = mean(&|pair| (pair[1] - at_1m - slope * pair[0]).powi(2)).sqrt();
        (deviation >= LEAST_DEVIATION).then_some(Self { at_1m, slope, deviation })
    }

    /// Deviations of an intensity at a range from the trend.
    pub fn contrast(&self, intensity: f64, range_m: f64) -> f64 {
        (intensity.log2() - self.at_1m - self.slope * range_m.log2()) / self.deviation
    }
}

/// log2 of range and intensity, where both are finite and above 0.
fn logarithms(point: &Point) -> Option<[f64; 2]> {
    let intensity = f64::from(point.intensity);
    let range_m = glam::DVec3::from(point.position_m().map(f64::from)).length();
    let usable = intensity > 0.0 && intensity.is_finite() && range_m > 0.01 && range_m.is_finite();
    usable.then(|| [range_m.log2(), intensity.log2()])
}
