//! People who walk through a scene.

use glam::DVec2;
use serde::{Deserialize, Serialize};

use super::scene::Cylinder;

/// A person: an upright cylinder that goes from point to point, and from the last one back, at a steady pace.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Walker {
    /// Points of the way, metres; one is a person who stands.
    pub waypoints_m: Vec<[f64; 2]>,
    /// Metres a second.
    #[serde(default = "default_speed_m_s")]
    pub speed_m_s: f64,
    /// Seconds of the way that lie before the first frame.
    #[serde(default)]
    pub ahead_s: f64,
    /// Metres.
    #[serde(default = "default_radius_m")]
    pub radius_m: f64,
    /// Metres.
    #[serde(default = "default_height_m")]
    pub height_m: f64,
    /// Name of its material.
    pub material: String,
}

fn default_speed_m_s() -> f64 {
    1.2
}

fn default_radius_m() -> f64 {
    0.2
}

fn default_height_m() -> f64 {
    1.7
}

impl Walker {
    /// Where the person is so many seconds after the first frame, metres.
    pub fn place_m(&self, seconds: f64) -> DVec2 {
        let points: Vec<DVec2> = self.waypoints_m.iter().copied().map(DVec2::from_array).collect();
        let legs: Vec<(DVec2, DVec2)> = points.windows(2).map(|ends| (ends[0], ends[1])).collect();
        let length_m: f64 = legs.iter().map(|(from, to)| from.distance(*to)).sum();
        let last = points.last().copied().unwrap_or(DVec2::ZERO);
        if length_m <= 0.0 {
            return last;
        }
        let gone_m = ((seconds + self.ahead_s) * self.speed_m_s).rem_euclid(2.0 * length_m);
        // The second half of a round is the way back.
        let mut left_m = if gone_m > length_m { 2.0 * length_m - gone_m } else { gone_m };
        for (from, to) in legs {
            let leg_m = from.distance(to);
            if left_m <= leg_m && leg_m > 0.0 {
                return from.lerp(to, left_m / leg_m);
            }
            left_m -= leg_m;
        }
        last
    }

    /// The person as a thing that stands there.
    pub fn at(&self, seconds: f64) -> Cylinder {
        let DVec2 { x, y } = self.place_m(seconds);
        Cylinder {
            base_m: [x, y, 0.0],
            radius_m: self.radius_m,
            height_m: self.height_m,
            material: self.material.clone(),
        }
    }
}
