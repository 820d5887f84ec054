//! Whether a pane marks a cell (spec 3 §7).

use glam::{DVec2, DVec3};

/// An upright or leaning pane: its corners at the low left, the low right and the high left, metres in the window; z from the
/// lidar's height.
pub(crate) struct Corners {
    pub(crate) low_left: DVec3,
    pub(crate) low_right: DVec3,
    pub(crate) high_left: DVec3,
}

/// How well edges are known, metres.
const EDGE_M: f64 = 0.3;

/// Whether the pane's line at the lidar's height crosses the square cell around `centre_m`, and the pane reaches into the
/// heights `band_m`.
pub(crate) fn marks(pane: &Corners, centre_m: DVec2, cell_m: f64, band_m: Option<[f64; 2]>) -> bool {
    let (along, up) = (pane.low_right - pane.low_left, pane.high_left - pane.low_left);
    let normal = along.cross(up).normalize();
    if normal.z.abs() > 0.7 {
        return false;
    }
    let from = centre_m.extend(0.0) - pane.low_left;
    let share = from.dot(along) / along.length_squared();
    let slack = 0.5 * cell_m / along.length();
    let [low, high] = {
        let z = pane.low_left.z + share * along.z;
        [z.min(z + up.z) - EDGE_M, z.max(z + up.z) + EDGE_M]
    };
    let in_way = band_m.is_none_or(|[from_m, to_m]| high >= from_m && low <= to_m);
    let off = from.dot(normal).abs();
    off <= 0.5 * cell_m * (normal.x.abs() + normal.y.abs())
        && (-slack..=1.0 + slack).contains(&share)
        && in_way
}
