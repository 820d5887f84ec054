//! The rolling window kept by map cell, without a ring (spec 1 §3, local map).

use std::collections::HashMap;

/// Cells by map cell, with the corner of the window they belong to.
#[derive(Debug, Clone, Default)]
pub(crate) struct Kept<T> {
    pub(crate) cells: HashMap<[i64; 2], T>,
}

impl<T: Copy + Default> Kept<T> {
    /// Forgets what lies outside a window of `side` cells from `origin`.
    pub(crate) fn move_to(&mut self, origin: [i64; 2], side: i64) {
        self.cells.retain(|cell, _| (0..2).all(|axis| (0..side).contains(&(cell[axis] - origin[axis]))));
    }

    /// The cell, at its default where it is not kept.
    pub(crate) fn get(&self, cell: [i64; 2]) -> T {
        self.cells.get(&cell).copied().unwrap_or_default()
    }
}
