//! Settings of the simulated camera: its place, imagers, projector and stereo matcher (spec 1 §8).

use serde::{Deserialize, Serialize};

use crate::base::{Error, Result};
use crate::sensor::{CameraModel, Distortion};

/// Focal length of a D435's depth stream over its width: 425 pixels at 848.
const FOCAL_OVER_WIDTH: f64 = 425.0 / 848.0;

/// The camera's image and its place on the robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Camera {
    /// Pixels, a multiple of 8.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Height of the optical centre of the left imager above the ground, metres.
    pub height_m: f64,
    /// How far it lies before the robot's centre, metres.
    pub forward_m: f64,
    /// How far it looks down, radians.
    pub pitch_rad: f64,
    /// Distance of the two imagers, metres.
    pub baseline_m: f64,
}

impl Default for Camera {
    fn default() -> Self {
        Self { width: 848, height: 480, height_m: 0.5, forward_m: 0.15, pitch_rad: 0.32, baseline_m: 0.05 }
    }
}

impl Camera {
    /// The pinhole model of both imagers, and of the colour images, which lie on the left imager's grid.
    pub fn model(&self) -> CameraModel {
        let focal = FOCAL_OVER_WIDTH * f64::from(self.width);
        CameraModel {
            width: self.width,
            height: self.height,
            fx: focal,
            fy: focal,
            cx: f64::from(self.width - 1) / 2.0,
            cy: f64::from(self.height - 1) / 2.0,
            distortion: Distortion::None,
        }
    }
}

/// The two infrared imagers and the projector.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Imager {
    /// Irradiance of the projector at 1 m, in the unit of the scene's lights.
    pub projector: f64,
    /// Size of the projector's dots, pixels.
    pub speckle_px: f64,
    /// How much the dots stand out, 0 to 1.
    pub speckle_contrast: f64,
    /// Mean that auto exposure brings the left image to, as a share of full scale.
    pub exposure_mean: f64,
    /// Largest gain of auto exposure: full scale over the radiance that reaches it.
    pub largest_gain: f64,
    /// Gain up to which exposure time alone serves; above it the signal is amplified, and its noise.
    pub full_gain: f64,
    /// Factor on what auto exposure finds.
    pub exposure_bias: f64,
    /// Electrons at full scale.
    pub electrons: f64,
    /// Read noise, levels of 255.
    pub read_noise: f64,
}

impl Default for Imager {
    fn default() -> Self {
        Self {
            projector: 3.0,
            speckle_px: 2.6,
            speckle_contrast: 0.9,
            exposure_mean: 0.3,
            largest_gain: 60.0,
            full_gain: 6.0,
            exposure_bias: 1.0,
            electrons: 6000.0,
            read_noise: 0.6,
        }
    }
}

/// The stereo matcher: 9x7 census summed over 5x5, winner takes all.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Matcher {
    /// Disparities searched at a width of 848 (rounded up to a multiple of 8 at others).
    pub disparities: u32,
    /// The second best match must cost more by this share.
    pub uniqueness: f64,
    /// Largest difference of the left and right image's disparities, pixels.
    pub left_right_px: f64,
    /// Least deviation of grey in 9x7 pixels, levels of 255.
    pub texture: f64,
    /// Largest share of differing bits in a match.
    pub largest_cost: f64,
    /// Disparities are rounded to multiples of this, pixels.
    pub step_px: f64,
}

impl Default for Matcher {
    fn default() -> Self {
        Self {
            disparities: 64,
            uniqueness: 0.03,
            left_right_px: 1.0,
            texture: 0.8,
            largest_cost: 0.36,
            step_px: 1.0 / 32.0,
        }
    }
}

impl Matcher {
    /// Disparities searched in images of `width` pixels, a multiple of 8.
    pub fn disparities_at(&self, width: u32) -> u32 {
        (self.disparities * width).div_ceil(848).next_multiple_of(8)
    }
}

/// Checks numbers and names their keys.
pub(crate) struct Checks<'a> {
    /// Path of the section, with a dot at its end.
    pub(crate) section: &'a str,
}

impl Checks<'_> {
    pub(crate) fn within(&self, values: &[(&str, f64, f64, f64)]) -> Result<()> {
        for &(key, value, least, most) in values {
            if !(least..=most).contains(&value) {
                let reason = format!("{value} is not a number in [{least}, {most}]");
                return Err(bad(format!("{}{key}", self.section), reason));
            }
        }
        Ok(())
    }
}

pub(crate) fn bad(key: impl Into<String>, reason: impl Into<String>) -> Error {
    Error::Config { key: key.into(), reason: reason.into() }
}

impl Camera {
    /// # Errors
    /// [`Error::Config`] that names the key.
    pub fn validate(&self) -> Result<()> {
        if !self.width.is_multiple_of(8) || !(64..=1280).contains(&self.width) {
            return Err(bad("camera.width", format!("{} is not a multiple of 8 in 64..=1280", self.width)));
        }
        if !(16..=800).contains(&self.height) {
            return Err(bad("camera.height", format!("{} is not in 16..=800", self.height)));
        }
        Checks { section: "camera." }.within(&[
            ("height_m", self.height_m, 0.05, 2.0),
            ("forward_m", self.forward_m, -1.0, 1.0),
            ("pitch_rad", self.pitch_rad, -1.2, 1.2),
            ("baseline_m", self.baseline_m, 0.005, 0.5),
        ])
    }
}

impl Imager {
    /// # Errors
    /// [`Error::Config`] that names the key.
    pub fn validate(&self) -> Result<()> {
        Checks { section: "imager." }.within(&[
            ("projector", self.projector, 0.0, 1e3),
            ("speckle_px", self.speckle_px, 1.0, 40.0),
            ("speckle_contrast", self.speckle_contrast, 0.0, 1.0),
            ("exposure_mean", self.exposure_mean, 0.01, 0.9),
            ("largest_gain", self.largest_gain, 1e-3, 1e6),
            ("full_gain", self.full_gain, 1e-3, 1e6),
            ("exposure_bias", self.exposure_bias, 0.05, 20.0),
            ("electrons", self.electrons, 10.0, 1e6),
            ("read_noise", self.read_noise, 0.0, 50.0),
        ])
    }
}

impl Matcher {
    /// # Errors
    /// [`Error::Config`] that names the key.
    pub fn validate(&self) -> Result<()> {
        if !(16..=256).contains(&self.disparities) {
            return Err(bad("matcher.disparities", format!("{} is not in 16..=256", self.disparities)));
        }
        Checks { section: "matcher." }.within(&[
            ("uniqueness", self.uniqueness, 0.0, 0.9),
            ("left_right_px", self.left_right_px, 0.0, 100.0),
            ("texture", self.texture, 0.0, 128.0),
            ("largest_cost", self.largest_cost, 0.01, 1.0),
            ("step_px", self.step_px, 1e-3, 1.0),
        ])
    }
}
