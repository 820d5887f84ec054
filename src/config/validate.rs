//! What values the parameters may have.

use super::{Config, bad_key};
use crate::base::Result;
use crate::sensor::Distortion;

impl Config {
    /// Checks every value and their relations.
    ///
    /// # Errors
    /// [`crate::Error::Config`] for the first key at fault.
    pub fn validate(&self) -> Result<()> {
        self.numbers()?;
        self.lens()?;
        self.shares()?;
        self.orders()?;
        self.counts()?;
        if self.inflation_radius_m > 254.0 * self.resolution_m {
            let largest = 254.0 * self.resolution_m;
            return Err(bad_key("inflation_radius_m", format!("is above 254 cells ({largest} m)")));
        }
        self.validate_map()?;
        self.validate_lidar()?;
        super::glass::check(self)?;
        self.cells_per_side()?;
        self.validate_sensors()
    }

    fn numbers(&self) -> Result<()> {
        positive(&[
            ("resolution_m", self.resolution_m),
            ("map_size_m", self.map_size_m),
            ("depth_unit_m", self.depth_unit_m),
            ("float_depth_unit_m", self.float_depth_unit_m),
            ("depth_max_m", self.depth_max_m),
            ("range_gate_m", self.range_gate_m),
            ("mark_range_m", self.mark_range_m),
            ("cost_scaling_factor", self.cost_scaling_factor),
            ("evidence_least_hits", self.evidence_least_hits),
        ])?;
        from_0_up(&[
            ("pair_tolerance_s", self.pair_tolerance_s),
            ("transform_tolerance_s", self.transform_tolerance_s),
            ("depth_min_m", self.depth_min_m),
            ("inflation_radius_m", self.inflation_radius_m),
            ("inscribed_radius_m", self.inscribed_radius_m),
            ("evidence_exponent", self.evidence_exponent),
        ])?;
        if !self.ground_z_m.is_finite() {
            return Err(bad_key("ground_z_m", format!("{} is not finite", self.ground_z_m)));
        }
        Ok(())
    }

    /// The stated lens.
    fn lens(&self) -> Result<()> {
        if !self.distortion.is_empty() && self.camera_matrix == [0.0; 9] {
            return Err(bad_key(
                "distortion",
                "is stated without `camera_matrix`, to which it belongs".into(),
            ));
        }
        let lens = Distortion::from_ros(&self.distortion_model, &self.distortion);
        lens.map(drop).map_err(|error| bad_key("distortion", error.to_string()))
    }

    fn shares(&self) -> Result<()> {
        for (key, value) in [
            ("tau", self.tau),
            ("lambda", self.lambda),
            ("occupied_threshold", self.occupied_threshold),
            ("free_threshold", self.free_threshold),
            ("degraded_fraction", self.degraded_fraction),
        ] {
            if !(0.0..=1.0).contains(&value) {
                return Err(bad_key(key, format!("{value} is not in [0, 1]")));
            }
        }
        Ok(())
    }

    fn orders(&self) -> Result<()> {
        for (low_key, low, high_key, high) in [
            ("height_min_m", self.height_min_m, "height_max_m", self.height_max_m),
            ("depth_min_m", self.depth_min_m, "depth_max_m", self.depth_max_m),
            ("depth_min_m", self.depth_min_m, "range_gate_m", self.range_gate_m),
        ] {
            if low.partial_cmp(&high) != Some(std::cmp::Ordering::Less) {
                return Err(bad_key(low_key, format!("{low} is not below `{high_key}` = {high}")));
            }
        }
        if self.free_threshold > self.occupied_threshold {
            return Err(bad_key(
                "free_threshold",
                "is above `occupied_threshold`: the hysteresis would never settle".into(),
            ));
        }
        if self.inscribed_radius_m > self.inflation_radius_m {
            return Err(bad_key(
                "inscribed_radius_m",
                "is above `inflation_radius_m`: the robot would be larger than its safety margin".into(),
            ));
        }
        Ok(())
    }

    fn counts(&self) -> Result<()> {
        if self.cloud_stride > 1024 {
            return Err(bad_key("cloud_stride", format!("{} is not in 0..=1024", self.cloud_stride)));
        }
        for (key, value, max) in [
            ("confirmations", self.confirmations, 200),
            ("min_hits", self.min_hits, 1_000_000),
            ("temporal_window", self.temporal_window, 16),
            ("temporal_hits", self.temporal_hits, self.temporal_window),
        ] {
            if !(1..=max).contains(&value) {
                return Err(bad_key(key, format!("{value} is not in 1..={max}")));
            }
        }
        Ok(())
    }
}

/// That each of these keys has a positive number.
pub(super) fn positive(keys: &[(&str, f64)]) -> Result<()> {
    match keys.iter().find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
        Some((key, value)) => Err(bad_key(key, format!("{value} is not a positive number"))),
        None => Ok(()),
    }
}

/// That each of these keys has a number from 0 up.
pub(super) fn from_0_up(keys: &[(&str, f64)]) -> Result<()> {
    match keys.iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
        Some((key, value)) => Err(bad_key(key, format!("{value} is not a number from 0 up"))),
        None => Ok(()),
    }
}
