//! What beams show that go on behind a wall (spec 6 §4), of nearest returns in the order of their cells.

use glam::DVec3;

use super::floor_images::Cells;

const BEHIND_M: f64 = 0.3;
const GRAZING_COS: f64 = 0.17;
const STRIP_M: f64 = 0.125;
const STRIPS: f64 = 256.0;

/// A wall: its normal, distance and level axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wall {
    pub(crate) normal: DVec3,
    pub(crate) distance_m: f64,
    pub(crate) level: DVec3,
}

/// What a strip of a wall counts of beams that go on: all, with two returns, images, missing ones, refuted ones, proofs.
pub(crate) type Counts = [u32; 6];

impl Wall {
    /// The strip through which a beam goes on, if it does.
    pub(crate) fn strip(&self, at: DVec3) -> Option<usize> {
        let reach = self.normal.dot(at);
        if reach - self.distance_m <= BEHIND_M || reach <= GRAZING_COS * at.length() {
            return None;
        }
        let u = self.level.dot(at) * self.distance_m / reach;
        let strip = u / STRIP_M + 0.5 * STRIPS;
        (0.0..STRIPS).contains(&strip).then_some(strip as usize)
    }

    /// What a beam adds to its strip that ends at `at`, with two returns or one.
    pub(crate) fn counts(&self, cells: &Cells<'_>, at: DVec3, dual: bool) -> Counts {
        let over = self.normal.dot(at) - self.distance_m;
        let shown = |off_m: f64| {
            let place = at - 2.0 * (over + off_m) * self.normal;
            cells.shown(place, 0.5 * cells.tolerance_m(place))
        };
        let [matches, beyond, known] = shown(0.0);
        let proves = matches && !dual && !shown(0.4)[0] && !shown(-0.4)[0];
        [true, dual, matches, known && !matches, beyond && !matches, proves].map(u32::from)
    }
}
