//! The lidar path's parameters: choices, and what values they may have (spec 2).

use serde::{Deserialize, Serialize};

use super::validate::{from_0_up, positive};
use super::{Config, bad_key, cells};
use crate::base::Result;

/// Where the planes z = 0 and z = -epsilon come from (spec 2 §2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PlaneSource {
    /// The rings where the first scan has some, else slabs.
    Auto,
    /// The ring nearest the horizontal and the one below it.
    Rings,
    /// Points within half a thickness of a height.
    Slabs,
}

/// What makes a cell solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Solidity {
    /// [`Self::Learned`] where no gamma is stated; else by intensity while the scans bear out its full scale and gamma, and
    /// what stands where they do not.
    Auto,
    /// A layer above gamma (spec 2 §3), whatever the scans say of the scale.
    Intensity,
    /// A model of shape and of beams that go on behind (spec 6 §3), whatever the scale of intensities.
    Learned,
    /// Any return that stands above the ground: nothing that stands is passable.
    Standing,
}

/// What a layer's value is made of (spec 2 §2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LayerMeasure {
    /// The paper's: sum of intensities (shares of full scale) over the cell's area, 1/m2.
    Sum,
    /// Mean intensity of the returns, share of full scale.
    Mean,
    /// Sum of intensities over the number of beams that a wall there would return, share of full scale.
    Expected,
}

/// Shape of the inflation (spec 2 §4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InflationKernel {
    /// From the obstacle away from the goal, and a small disc.
    Adaptive,
    /// The paper's printed form: the line both ways, and the disc.
    Symmetric,
    /// A square of ones.
    Uniform,
}

/// Most tall layers; the shader holds their bounds in a uniform.
pub const MAX_TALL_LAYERS: usize = 16;

/// Farthest reach of the inflation, cells.
const MAX_REACH_CELLS: f64 = 64.0;

/// Gamma where none is stated, share of full scale.
const GAMMA: f64 = 0.5;

impl Config {
    /// Gamma as stated, else 0.5.
    pub fn gamma_or_default(&self) -> f64 {
        self.gamma.unwrap_or(GAMMA)
    }

    /// What makes a cell solid: [`Solidity::Auto`] settles for [`Solidity::Learned`] where no gamma is stated.
    pub fn settled_solidity(&self) -> Solidity {
        match self.solidity {
            Solidity::Auto if self.gamma.is_none() => Solidity::Learned,
            stated => stated,
        }
    }

    /// Cells along one side of the lidar map.
    ///
    /// # Errors
    /// [`crate::Error::Config`] where size and resolution give fewer than 8 or more than 4096 cells.
    pub fn scan_cells_per_side(&self) -> Result<u32> {
        cells("scan_map_size_m", self.scan_map_size_m, self.scan_resolution_m)
    }

    pub(super) fn validate_lidar(&self) -> Result<()> {
        self.scan_numbers()?;
        self.scan_layers()?;
        self.scan_inflation()?;
        self.scan_cells_per_side().map(|_| ())
    }

    fn scan_numbers(&self) -> Result<()> {
        positive(&[
            ("scan_resolution_m", self.scan_resolution_m),
            ("scan_map_size_m", self.scan_map_size_m),
        ])?;
        from_0_up(&[
            ("intensity_full_scale", self.intensity_full_scale),
            ("pose_jump_m_s", self.pose_jump_m_s),
            ("pose_jump_deg_s", self.pose_jump_deg_s),
            ("plane_below_m", self.plane_below_m),
            ("plane_half_thickness_m", self.plane_half_thickness_m),
            ("azimuth_step_deg", self.azimuth_step_deg),
            ("elevation_step_deg", self.elevation_step_deg),
            ("gamma", self.gamma_or_default()),
            ("transparent_threshold", self.transparent_threshold),
            ("transparent_decay_s", self.transparent_decay_s),
            ("transparent_clear", self.transparent_clear),
            ("inflation_length_m", self.inflation_length_m),
            ("inflation_side_m", self.inflation_side_m),
        ])?;
        if !(self.intensity_percentile > 0.0 && self.intensity_percentile <= 100.0) {
            let reason = format!("{} is not in (0, 100]", self.intensity_percentile);
            return Err(bad_key("intensity_percentile", reason));
        }
        if !(self.goal_m.is_empty() || self.goal_m.len() == 2 && self.goal_m.iter().all(|m| m.is_finite())) {
            return Err(bad_key("goal_m", format!("{:?} is neither [] nor [x, y]", self.goal_m)));
        }
        if self.min_returns == 0 {
            return Err(bad_key("min_returns", "is 0; a cell needs a return to be decided".into()));
        }
        Ok(())
    }

    fn scan_layers(&self) -> Result<()> {
        let heights = &self.layer_heights_m;
        let bad = |reason: String| Err(bad_key("layer_heights_m", reason));
        if heights.len() < 2 || heights.len() > MAX_TALL_LAYERS + 1 {
            return bad(format!("has {} bounds; 2 to {} are supported", heights.len(), MAX_TALL_LAYERS + 1));
        }
        if heights.iter().any(|h| !h.is_finite()) || heights.windows(2).any(|pair| pair[0] >= pair[1]) {
            return bad(format!("{heights:?} does not ascend"));
        }
        if heights[0] >= 0.0 || heights[heights.len() - 1] <= 0.0 {
            return bad(format!("{heights:?} does not begin below the sensor (0) and end above it"));
        }
        if self.layer_measure == LayerMeasure::Expected {
            let [low, high] = self.elevation_range_deg;
            for (key, fits) in [
                ("azimuth_step_deg", self.azimuth_step_deg > 0.0),
                ("elevation_step_deg", self.elevation_step_deg > 0.0),
                ("elevation_range_deg", -90.0 < low && low < high && high < 90.0),
            ] {
                if !fits {
                    let reason = "must be that of the sensor for layer_measure expected".into();
                    return Err(bad_key(key, reason));
                }
            }
        }
        Ok(())
    }

    fn scan_inflation(&self) -> Result<()> {
        for (key, reach_m) in [
            ("inflation_length_m", self.inflation_length_m),
            ("inflation_side_m", self.inflation_side_m),
            ("inscribed_radius_m", self.inscribed_radius_m),
        ] {
            let most_m = MAX_REACH_CELLS * self.scan_resolution_m;
            if reach_m > most_m {
                return Err(bad_key(key, format!("is above {MAX_REACH_CELLS} cells ({most_m} m)")));
            }
        }
        if self.inflation_padding_cells > 32 {
            let reason = format!("{} is not in 0..=32", self.inflation_padding_cells);
            return Err(bad_key("inflation_padding_cells", reason));
        }
        if self.passable_cost > 252 {
            return Err(bad_key("passable_cost", format!("{} is not in 0..=252", self.passable_cost)));
        }
        Ok(())
    }
}
