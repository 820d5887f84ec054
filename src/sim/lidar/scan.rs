//! A simulated scan, with the truth of each of its points.

use glam::DVec3;

use crate::sensor::Scan;

/// Bits of [`PointTruth::flags`] as the shader `sim/beam` has them.
const OF_GLASS: u8 = 1;
const REFLECTED: u8 = 2;
const BEHIND: u8 = 4;
const PASSABLE: u8 = 8;

/// Where a point's light was really sent back, and by what.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointTruth {
    /// The surface that was met, in the map frame, metres (to 1/256 m).
    pub place_m: DVec3,
    /// Number of its material: its place in the order of the scene's names; lamps and windows follow.
    pub material: u8,
    /// 1: the pane or mirror itself; 2: met by way of a mirror image, so that the point lies elsewhere; 4: met through a pane;
    /// 8: something that a robot can pass.
    pub flags: u8,
}

impl PointTruth {
    /// Whether it is the pane or mirror itself.
    pub fn is_glass(&self) -> bool {
        self.flags & OF_GLASS != 0
    }

    /// Whether it was met by way of a mirror image.
    pub fn is_reflection(&self) -> bool {
        self.flags & REFLECTED != 0
    }

    /// Whether it was met through a pane.
    pub fn is_behind(&self) -> bool {
        self.flags & BEHIND != 0
    }

    /// Whether a robot can pass it: grass, strings.
    pub fn is_passable(&self) -> bool {
        self.flags & PASSABLE != 0
    }
}

/// One revolution as the sensor gives it, and what is true of it.
#[derive(Debug, Clone, PartialEq)]
pub struct SimScan {
    /// Points in the sensor's frame at the time of their firing; the stamp is that of the first firing.
    pub scan: Scan,
    /// Of each point.
    pub truth: Vec<PointTruth>,
    /// Beams that were sent.
    pub beams: u32,
}

/// What the shader `sim/echo` gives of a slot: range (0: none), intensity, and the truth's words.
pub(super) struct Echo([u32; 4]);

impl Echo {
    /// Of a slot's words.
    pub(super) fn of(words: [u32; 4]) -> Option<Self> {
        (f32::from_bits(words[0]) > 0.0).then_some(Self(words))
    }

    /// Metres.
    pub(super) fn range_m(&self) -> f32 {
        f32::from_bits(self.0[0])
    }

    /// In the sensor's unit.
    pub(super) fn intensity(&self) -> f32 {
        f32::from_bits(self.0[1])
    }

    /// Of the surface; `origin_m`: the sensor in the map.
    pub(super) fn truth(&self, origin_m: DVec3) -> PointTruth {
        let [_, _, third, fourth] = self.0;
        let [material, flags, x0, x1] = third.to_le_bytes();
        let [y0, y1, z0, z1] = fourth.to_le_bytes();
        let place = [[x0, x1], [y0, y1], [z0, z1]].map(|b| f64::from(i16::from_le_bytes(b)) / 256.0);
        PointTruth { place_m: origin_m + DVec3::from_array(place), material, flags }
    }
}
