//! Bottles, bowls, glasses, jars: upright surfaces of revolution, clear or not, empty or filled.

use serde::{Deserialize, Serialize};

use super::scene::Scene;
use super::settings::bad;
use crate::base::Result;

/// An upright surface of revolution, made of cones, cylinders and level discs.
///
/// Its outline is followed so that the body lies to the left: from the axis at the bottom outwards, up, and back
/// inwards. Clear material of `refractive_index` 1 is a thin wall that light passes straight. With a higher index the
/// outline encloses that material and bends light: a solid body, or a thick wall whose outline comes down again on the
/// inside and ends at the axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vessel {
    /// Where height 0 of the outline lies on the axis, metres.
    pub base_m: [f64; 3],
    /// Radius and height of the outline's corners, metres.
    pub profile_m: Vec<[f64; 2]>,
    /// Name of its material.
    pub material: String,
    /// Height up to which it is filled, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fill_m: Option<f64>,
    /// Name of the material that it is filled with: clear, with a `refractive_index`, or not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contents: Option<String>,
}

/// A piece of a vessel's surface between two heights, or a level ring between two radii.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Frustum {
    /// Radius and height at its lower (or inner) end, metres.
    pub(crate) low_m: [f64; 2],
    /// At its upper (or outer) end.
    pub(crate) high_m: [f64; 2],
    /// 1 where the body lies on the axis' side (of a disc: below it), -1 where it lies on the other.
    pub(crate) facing: f64,
    /// Refractive indices of the body and of what lies around it.
    pub(crate) indices: [f64; 2],
    /// Name of its material.
    pub(crate) material: String,
}

impl Frustum {
    /// Whether it is a level ring.
    pub(crate) fn is_disc(&self) -> bool {
        self.low_m[1] == self.high_m[1]
    }

    fn between(from: [f64; 2], to: [f64; 2], material: &str, index: f64) -> Self {
        let disc = from[1] == to[1];
        let rises = if disc { to[0] < from[0] } else { to[1] > from[1] };
        // A ring's inner end is its low one, whichever way it is followed.
        let as_followed = if disc { to[0] > from[0] } else { rises };
        let (low_m, high_m) = if as_followed { (from, to) } else { (to, from) };
        let facing = if rises { 1.0 } else { -1.0 };
        Self { low_m, high_m, facing, indices: [index, 1.0], material: material.into() }
    }
}

impl Vessel {
    /// Its largest radius, metres.
    pub(crate) fn radius_m(&self) -> f64 {
        self.profile_m.iter().map(|corner| corner[0]).fold(0.0, f64::max)
    }

    /// Its lowest and highest place, metres.
    pub(crate) fn span_m(&self) -> [f64; 2] {
        let heights = self.profile_m.iter().map(|corner| self.base_m[2] + corner[1]);
        [heights.clone().fold(f64::INFINITY, f64::min), heights.fold(f64::NEG_INFINITY, f64::max)]
    }

    /// Its surface, and that of what it is filled with; heights above `base_m`.
    pub(crate) fn frustums(&self, scene: &Scene) -> Vec<Frustum> {
        let index = scene.materials.get(&self.material).map_or(1.0, |m| m.refractive_index);
        let corners = self.corners();
        let pieces = corners.windows(2).map(|ends| (ends[0], ends[1]));
        let wall = pieces.map(|(from, to)| Frustum::between(from, to, &self.material, index));
        let mut frustums: Vec<Frustum> = wall.collect();
        let (Some(fill_m), Some(contents)) = (self.fill_m, &self.contents) else { return frustums };
        let within = scene.materials.get(contents);
        let opaque = within.is_some_and(|m| m.transmission == 0.0);
        let index_within = within.map_or(1.0, |m| m.refractive_index);
        for piece in frustums.iter_mut().filter(|piece| holds(piece, index, fill_m)) {
            piece.indices[usize::from(index > 1.0)] = index_within;
            if opaque {
                piece.material.clone_from(contents);
            }
        }
        if let Some(radius_m) = self.fill_radius_m(scene) {
            let (rim, axis) = ([radius_m, fill_m], [0.0, fill_m]);
            frustums.push(Frustum::between(rim, axis, contents, index_within));
        }
        frustums
    }

    /// The outline with a corner where the filling ends.
    fn corners(&self) -> Vec<[f64; 2]> {
        let mut corners: Vec<[f64; 2]> = Vec::new();
        for &corner in &self.profile_m {
            if let (Some(fill_m), Some(&last)) = (self.fill_m, corners.last()) {
                let share = (fill_m - last[1]) / (corner[1] - last[1]);
                if share > 0.0 && share < 1.0 {
                    corners.push([last[0] + share * (corner[0] - last[0]), fill_m]);
                }
            }
            corners.push(corner);
        }
        corners
    }

    /// Radius inside at the height of filling, metres; `None` where no inner wall has that height.
    pub(crate) fn fill_radius_m(&self, scene: &Scene) -> Option<f64> {
        let index = scene.materials.get(&self.material)?.refractive_index;
        let fill_m = self.fill_m?;
        let corners = self.corners();
        let mut pieces = corners.windows(2).map(|e| Frustum::between(e[0], e[1], &self.material, index));
        let reaches = |p: &Frustum| !p.is_disc() && p.high_m[1] == fill_m && holds(p, index, fill_m);
        pieces.find(reaches).map(|piece| piece.high_m[0])
    }

    /// Checks its outline and filling; names and places are checked as of all solids.
    pub(super) fn check(&self, scene: &Scene, section: &str) -> Result<()> {
        let key = |field: &str| format!("{section}{field}");
        let finite = |value: f64| (-100.0..=100.0).contains(&value);
        for &[radius_m, height_m] in &self.profile_m {
            if !finite(radius_m) || radius_m < 0.0 || !finite(height_m) {
                let reason = format!("[{radius_m}, {height_m}] is not a radius of at least 0 and a height");
                return Err(bad(key("profile_m"), reason));
            }
        }
        let [low_m, high_m] = self.span_m();
        if self.profile_m.len() < 2 || high_m <= low_m || self.radius_m() <= 0.0 {
            return Err(bad(
                key("profile_m"),
                "does not rise around its axis: two corners or more are needed",
            ));
        }
        if let Some(ends) = self.profile_m.windows(2).find(|ends| ends[0] == ends[1]) {
            return Err(bad(key("profile_m"), format!("{:?} is there twice in a row", ends[0])));
        }
        self.check_fill(scene, section)
    }

    fn check_fill(&self, scene: &Scene, section: &str) -> Result<()> {
        let key = |field: &str| format!("{section}{field}");
        let clear = scene.materials.get(&self.material).is_some_and(|m| m.transmission > 0.0);
        match (self.fill_m, &self.contents) {
            (None, None) => Ok(()),
            (Some(_), None) => Err(bad(key("contents"), "is missing, where `fill_m` is given")),
            (None, Some(_)) => Err(bad(key("fill_m"), "is missing, where `contents` is given")),
            _ if !clear => Err(bad(key("fill_m"), "only clear vessels show what is in them")),
            (Some(fill_m), _) if self.fill_radius_m(scene).is_none() => {
                Err(bad(key("fill_m"), format!("{fill_m} is not a height that an inner wall reaches")))
            }
            _ => Ok(()),
        }
    }
}

/// Whether a piece of wall borders on what the vessel is filled with: all of a thin wall, the inside of a thick one.
fn holds(piece: &Frustum, index: f64, fill_m: f64) -> bool {
    let inner_floor = piece.is_disc() && piece.facing > 0.0;
    piece.high_m[1] <= fill_m && (index == 1.0 || inner_floor || (!piece.is_disc() && piece.facing < 0.0))
}
