//! Geometry of a map.

/// Grid geometry: cell (0, 0) has its corner at the origin; row 0 is the smallest y.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// x of the corner of cell (0, 0) in the map frame, metres; a multiple of the resolution.
    pub origin_x_m: f64,
    /// y of the corner of cell (0, 0) in the map frame, metres; a multiple of the resolution.
    pub origin_y_m: f64,
    /// Side of a cell, metres.
    pub resolution_m: f64,
    /// Cells along x.
    pub width: u32,
    /// Cells along y.
    pub height: u32,
}
