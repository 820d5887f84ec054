//! Solid, passable and transparent cells of a lidar's map against the true ones: the F-score of spec 7 §3.

use serde::{Deserialize, Serialize};

use crate::map::{CellClass, MapUpdate};
use crate::sim::truth::{GLASS, OCCUPIED, PASSABLE};

/// A cell is right where a true one of its class lies this near, cells, and the other way round.
const NEAR_CELLS: i64 = 1;

/// Counts of one class.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    /// Cells that the map calls so.
    pub called: u64,
    /// Of these, with a true one in or beside them.
    pub called_right: u64,
    /// True cells that the map says something of (a cell in or beside them is neither unknown nor free).
    pub there: u64,
    /// Of these, with a cell so called in or beside them.
    pub found: u64,
}

impl Counts {
    /// F-score; `None` where neither map nor truth have any.
    pub fn f_score(&self) -> Option<f64> {
        let share = crate::offline::eval::share;
        if self.called == 0 && self.there == 0 {
            return None;
        }
        let precision = share(self.called_right, self.called).unwrap_or(0.0);
        let recall = share(self.found, self.there).unwrap_or(0.0);
        Some(if precision + recall > 0.0 { 2.0 * precision * recall / (precision + recall) } else { 0.0 })
    }

    fn add(&mut self, other: &Self) {
        self.called += other.called;
        self.called_right += other.called_right;
        self.there += other.there;
        self.found += other.found;
    }
}

/// Counts by class.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ClassTally {
    /// Walls, furniture, trunks.
    pub solid: Counts,
    /// Grass, strings.
    pub passable: Counts,
    /// Glass.
    pub transparent: Counts,
}

impl ClassTally {
    /// Of a map with the true cells on its window.
    pub fn of(map: &MapUpdate, truth: &[i8]) -> Self {
        if map.classes.len() != truth.len() {
            return Self::default();
        }
        let count = |class: CellClass, truth_code: i8| counts(map, truth, class, truth_code);
        Self {
            solid: count(CellClass::Solid, OCCUPIED),
            passable: count(CellClass::Passable, PASSABLE),
            transparent: count(CellClass::Transparent, GLASS),
        }
    }

    /// Adds another's counts.
    pub fn add(&mut self, other: &Self) {
        self.solid.add(&other.solid);
        self.passable.add(&other.passable);
        self.transparent.add(&other.transparent);
    }

    /// F-score over all three: sums of their counts.
    pub fn f_score(&self) -> Option<f64> {
        let mut all = self.solid;
        all.add(&self.passable);
        all.add(&self.transparent);
        all.f_score()
    }
}

fn counts(map: &MapUpdate, truth: &[i8], class: CellClass, code: i8) -> Counts {
    let mut counts = Counts::default();
    let is_class = |cell: usize| map.classes[cell] == class as u8;
    let says = |cell: usize| {
        [CellClass::Solid, CellClass::Passable, CellClass::Transparent]
            .iter()
            .any(|class| map.classes[cell] == *class as u8)
    };
    for cell in 0..truth.len() {
        if is_class(cell) {
            counts.called += 1;
            counts.called_right += u64::from(near(map, cell, |other| truth[other] == code));
        }
        if truth[cell] == code && near(map, cell, says) {
            counts.there += 1;
            counts.found += u64::from(near(map, cell, is_class));
        }
    }
    counts
}

/// Whether something holds of a cell or of one beside it.
fn near(map: &MapUpdate, cell: usize, test: impl Fn(usize) -> bool) -> bool {
    let (width, height) = (i64::from(map.grid.width), i64::from(map.grid.height));
    let cell = i64::try_from(cell).unwrap_or(0);
    let (x, y) = (cell % width, cell / width);
    let rows = (y - NEAR_CELLS).max(0)..=(y + NEAR_CELLS).min(height - 1);
    rows.flat_map(|row| {
        ((x - NEAR_CELLS).max(0)..=(x + NEAR_CELLS).min(width - 1)).map(move |column| row * width + column)
    })
    .any(|other| usize::try_from(other).is_ok_and(&test))
}
