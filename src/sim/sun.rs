//! Sunlight that comes in through windows, or from an open sky.

use serde::{Deserialize, Serialize};

/// The sun: parallel light that makes patches where it comes in through a window, shadowed by what stands in its way.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sun {
    /// Direction in which it stands, counter-clockwise from x.
    pub yaw_rad: f64,
    /// Its height above the horizon.
    pub elevation_rad: f64,
    /// Radiance of a white matt surface that faces it, in red, green and blue.
    pub color: [f64; 3],
    /// The same in the infrared.
    pub infrared: f64,
}
