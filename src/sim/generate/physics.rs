//! What the glare levels are: numbers of physics, never of damage (spec 1 §8).

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
                floor_reflectance: 0.06,
                floor_roughness: 0.03,
                floor_albedo: 0.20,
                lamp_infrared: 1.5,
                window_infrared: 6.0,
                window_m: 1.4,
                ambient_infrared: 0.03,
                glass: false,
            },
            Level::L2 => Self {
                floor_reflectance: 0.15,
                floor_roughness: 0.01,
                floor_albedo: 0.06,
                lamp_infrared: 5.0,
                window_infrared: 25.0,
                window_m: 1.8,
                ambient_infrared: 0.05,
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
