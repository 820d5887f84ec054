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

impl Grid {
    /// Column and row of the cell at a place in the map; `None` outside.
    pub fn cell_at(&self, x_m: f64, y_m: f64) -> Option<[u32; 2]> {
        let along = |at_m: f64, origin_m: f64, cells: u32| {
            let cell = ((at_m - origin_m) / self.resolution_m).floor();
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in 0..cells")]
            (cell >= 0.0 && cell < f64::from(cells)).then_some(cell as u32)
        };
        Some([along(x_m, self.origin_x_m, self.width)?, along(y_m, self.origin_y_m, self.height)?])
    }

    /// The centre of a cell in the map, metres.
    pub fn centre_m(&self, column: u32, row: u32) -> [f64; 2] {
        let along = |origin_m: f64, cell: u32| origin_m + (f64::from(cell) + 0.5) * self.resolution_m;
        [along(self.origin_x_m, column), along(self.origin_y_m, row)]
    }
}
