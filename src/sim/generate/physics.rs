//! What the glare levels are: numbers of physics, never of damage.
//!
//! Spec 1 §8 has the feasibility study's numbers as a start. With windows, lamps and rooms as they are here L1 and L2 take
//! more light and gloss than there to reach the same hole and spike rates; all settings of the sensor stay the same.

use super::{Level, Random};

/// Light and gloss of a level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Physics {
    /// F0 of the floor.
    pub floor_reflectance: f64,
    /// Of the floor.
    pub floor_roughness: f64,
    /// Of the floor, in the infrared.
    pub floor_albedo: f64,
    /// Radiance of lamps in the infrared.
    pub lamp_infrared: f64,
    /// Radiance of windows in the infrared; 0: none.
    pub window_infrared: f64,
    /// Side of windows, metres.
    pub window_m: f64,
    /// Infrared from everywhere.
    pub ambient_infrared: f64,
    /// Whether there is a glass pane.
    pub glass: bool,
}

impl Physics {
    /// The level's middle values.
    pub fn of(level: Level) -> Self {
        match level {
            Level::L0 => Self {
                floor_reflectance: 0.0,
                floor_roughness: 0.0,
                floor_albedo: 0.45,
                lamp_infrared: 0.10,
                window_infrared: 0.0,
                window_m: 0.0,
                ambient_infrared: 0.01,
                glass: false,
            },
            Level::L1 => Self {
                floor_reflectance: 0.12,
                floor_roughness: 0.008,
                floor_albedo: 0.08,
                lamp_infrared: 4.5,
                window_infrared: 24.0,
                window_m: 1.4,
                ambient_infrared: 0.4,
                glass: false,
            },
            Level::L2 => Self {
                floor_reflectance: 0.20,
                floor_roughness: 0.005,
                floor_albedo: 0.033,
                lamp_infrared: 13.0,
                window_infrared: 150.0,
                window_m: 1.8,
                ambient_infrared: 1.8,
                glass: true,
            },
        }
    }

    /// The level's values, each up to 15 % off.
    pub fn drawn(level: Level, random: &mut Random) -> Self {
        let middle = Self::of(level);
        let mut about = |value: f64| random.about(value, 0.15);
        Self {
            floor_reflectance: about(middle.floor_reflectance),
            floor_roughness: about(middle.floor_roughness),
            floor_albedo: about(middle.floor_albedo),
            lamp_infrared: about(middle.lamp_infrared),
            window_infrared: about(middle.window_infrared),
            window_m: about(middle.window_m),
            ambient_infrared: about(middle.ambient_infrared),
            glass: middle.glass,
        }
    }
}
