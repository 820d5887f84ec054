//! The rolling window of the map.

use crate::map::Grid;

/// Where the window lies for one frame, and how it got there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Window {
    /// Map cell of window cell (0, 0).
    pub origin: [i64; 2],
    /// Cells moved since the frame before, as far as they matter.
    pub shift: [i32; 2],
    /// Whether every cell starts unknown.
    pub forget: bool,
}

impl Window {
    /// Centred on (`x_m`, `y_m`) by whole cells; `before` is the window of the frame before.
    pub fn around(x_m: f64, y_m: f64, resolution_m: f64, side: u32, before: Option<Self>) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "saturates for positions beyond any map")]
        let cell = |at_m: f64| (at_m / resolution_m).floor() as i64;
        let half = i64::from(side / 2);
        let origin = [cell(x_m).saturating_sub(half), cell(y_m).saturating_sub(half)];
        Self { origin, ..Self::default() }.since(before, side)
    }

    /// The same place, moved from `before`.
    #[must_use]
    pub fn since(self, before: Option<Self>, side: u32) -> Self {
        let (origin, limit) = (self.origin, i64::from(side));
        let shift = before.map_or([0, 0], |b| {
            [0, 1].map(|axis| {
                let moved = origin[axis].saturating_sub(b.origin[axis]).clamp(-limit, limit);
                i32::try_from(moved).unwrap_or(0)
            })
        });
        Self { origin, shift, forget: before.is_none() }
    }

    /// Slot of window cell (0, 0) in the ring buffer of kept cells.
    pub fn origin_slot(&self, side: u32) -> [u32; 2] {
        self.origin.map(|cell| u32::try_from(cell.rem_euclid(i64::from(side))).unwrap_or(0))
    }

    /// Its geometry in the map.
    pub fn grid(&self, resolution_m: f64, side: u32) -> Grid {
        #[expect(clippy::cast_precision_loss, reason = "cells of any real map fit in 53 bits")]
        let metres = |cell: i64| cell as f64 * resolution_m;
        Grid {
            origin_x_m: metres(self.origin[0]),
            origin_y_m: metres(self.origin[1]),
            resolution_m,
            width: side,
            height: side,
        }
    }
}
