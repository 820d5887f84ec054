//! Settings of the simulated lidar: its model, mount and returns.

use glam::{DQuat, DVec3, EulerRot};
use serde::{Deserialize, Serialize};

use super::model::LidarModel;
use crate::base::{Result, Rigid};
use crate::sim::settings::{Checks, bad};

/// Which returns of a beam are reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Returns {
    /// The strongest.
    Strongest,
    /// The last, and the strongest or, where that is the last, the second strongest: Velodyne's dual mode.
    #[default]
    StrongestLast,
    /// The first and the last.
    FirstLast,
}

impl Returns {
    /// The number that the shader knows it by.
    pub(super) fn code(self) -> u32 {
        match self {
            Self::Strongest => 0,
            Self::StrongestLast => 1,
            Self::FirstLast => 2,
        }
    }
}

/// A lidar and its place on the robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Lidar {
    /// Which sensor.
    pub model: LidarModel,
    /// Which of a beam's returns it gives.
    pub returns: Returns,
    /// Revolutions a second.
    pub rate_hz: f64,
    /// Sub-rays that stand for a beam's cone.
    pub subrays: u32,
    /// Height of the sensor's centre above the ground, metres.
    pub height_m: f64,
    /// How far it lies before the robot's centre, metres.
    pub forward_m: f64,
    /// Roll, pitch and yaw of the mount (about x, y, z in this order, fixed axes), radians.
    pub tilt_rad: [f64; 3],
    /// Factor on its intensities.
    pub intensity_gain: f64,
    /// Whether recordings hold its raw packets in place of clouds: Velodynes.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub packets: bool,
}

impl Default for Lidar {
    fn default() -> Self {
        Self {
            model: LidarModel::Vlp16,
            returns: Returns::default(),
            rate_hz: 10.0,
            subrays: 16,
            height_m: 0.6,
            forward_m: 0.0,
            tilt_rad: [0.0; 3],
            intensity_gain: 1.0,
            packets: false,
        }
    }
}

impl Lidar {
    /// The sensor in the robot base.
    pub fn base_from_lidar(&self) -> Rigid {
        let [roll, pitch, yaw] = self.tilt_rad;
        Rigid {
            rotation: DQuat::from_euler(EulerRot::ZYX, yaw, pitch, roll),
            translation_m: DVec3::new(self.forward_m, 0.0, self.height_m),
        }
    }

    /// Columns of a revolution: fewer the faster it turns.
    pub fn columns(&self) -> u32 {
        let columns = f64::from(self.model.optics().columns) * 10.0 / self.rate_hz;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "rates are checked")]
        let columns = columns.round().clamp(90.0, 4096.0) as u32;
        columns
    }

    /// # Errors
    /// [`crate::Error::Config`] that names the key.
    pub fn validate(&self) -> Result<()> {
        if !(1..=32).contains(&self.subrays) {
            return Err(bad("lidar.subrays", format!("{} is not in 1..=32", self.subrays)));
        }
        if self.packets && self.model.velodyne().is_none() {
            return Err(bad("lidar.packets", format!("a {} sends none that are written", self.model.name())));
        }
        if self.packets && self.returns == Returns::FirstLast {
            return Err(bad("lidar.packets", "Velodynes send the strongest and the last return".to_owned()));
        }
        let checks = Checks { section: "lidar." };
        for angle in self.tilt_rad {
            checks.within(&[("tilt_rad", angle, -3.2, 3.2)])?;
        }
        checks.within(&[
            ("rate_hz", self.rate_hz, 1.0, 40.0),
            ("height_m", self.height_m, 0.05, 5.0),
            ("forward_m", self.forward_m, -2.0, 2.0),
            ("intensity_gain", self.intensity_gain, 1e-9, 1e9),
        ])
    }
}
