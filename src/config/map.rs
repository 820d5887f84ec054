//! The parameters of the one map and of when it is published: choices, and what values they may have (spec 4).

use serde::{Deserialize, Serialize};

use super::validate::{from_0_up, positive};
use super::{Config, bad_key};
use crate::base::Result;

/// Where the ground is taken from (spec 6 §2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GroundSource {
    /// What the sensors see of it; `ground_z_m` until they do, and where they see the same within noise.
    Estimate,
    /// `ground_z_m`, level.
    Stated,
}

/// How pixels of reliability R above tau change a cell (spec 1 §2, §3, §9). All cameras of a map have `Evidence`, or `Learned`,
/// or neither.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Fusion {
    /// By map reliability where a camera of the map has method drm and the cells have a side that its network knows, by evidence
    /// in cells of other sides, by weight without drm.
    Auto,
    /// By the mean of R over the hits, as in the paper.
    Weight,
    /// As by weight, with 1 in place of R.
    Gate,
    /// By evidence for the cell, which R speeds up, and evidence against it: the share of the pixels that look through it where it
    /// was hit.
    Evidence,
    /// As by evidence, but a small network decides which cells are obstacles, by what was seen of them and around them.
    Learned,
}

impl Fusion {
    /// Whether cells keep evidence for and against, else p.
    pub fn counts_trust(self) -> bool {
        matches!(self, Self::Evidence | Self::Learned)
    }
}

/// Which occupied cells of the cameras a lidar may refute (spec 4 §2, row 5).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LidarClearsCamera {
    /// None.
    Never,
    /// Those whose own evidence is weak.
    Doubtful,
    /// All.
    Always,
}

/// How costs fall around lethal cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InflationLaw {
    /// `Nav2` where the map has a camera, else `Goal`.
    Auto,
    /// Nav2's: exponential in the distance.
    Nav2,
    /// The goal-adaptive kernel (spec 2 §4).
    Goal,
}

/// Most points of a scan that a lidar's passes can be built for.
pub const MAX_POINTS: u32 = 1 << 20;

impl Config {
    /// The inflation law with [`InflationLaw::Auto`] resolved: Nav2's where the map has a camera, else the goal-adaptive.
    pub fn inflation_law(&self, has_camera: bool) -> InflationLaw {
        match self.inflation_law {
            InflationLaw::Auto if has_camera => InflationLaw::Nav2,
            InflationLaw::Auto => InflationLaw::Goal,
            stated => stated,
        }
    }

    /// Whether places below an estimated ground are drops.
    pub fn marks_drops(&self) -> bool {
        self.ground == GroundSource::Estimate && self.drop_m > 0.0
    }

    pub(super) fn validate_map(&self) -> Result<()> {
        from_0_up(&[
            ("timeout_s", self.timeout_s),
            ("cell_timeout_s", self.cell_timeout_s),
            ("order_window_s", self.order_window_s),
            ("drop_m", self.drop_m),
            ("wait_s", self.wait_s),
            ("publish_deadline_s", self.publish_deadline_s),
        ])?;
        positive(&[("publish_rate_hz", self.publish_rate_hz), ("ground_keep_s", self.ground_keep_s)])?;
        if !(0.0..=50.0).contains(&self.full_map_m) {
            return Err(bad_key("full_map_m", format!("{} is not in [0, 50]", self.full_map_m)));
        }
        let percent = self.degraded_speed_percent;
        if !(percent > 0.0 && percent <= 100.0) {
            let reason = format!("{percent} is not above 0 and up to 100; to Nav2 a limit of 0 is none");
            return Err(bad_key("degraded_speed_percent", reason));
        }
        if !(1..=MAX_POINTS).contains(&self.max_points) {
            return Err(bad_key("max_points", format!("{} is not in 1..={MAX_POINTS}", self.max_points)));
        }
        Ok(())
    }
}
