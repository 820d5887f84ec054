//! Costmaps against the true map: FOR, FSR and obstacle recall (spec 1 §6).

use serde::{Deserialize, Serialize};

use crate::base::{Error, Result};
use crate::config::Config;
use crate::map::Grid;
use crate::offline::eval::share;
use crate::sim::truth::{FREE, GLASS, OCCUPIED, TruthFrame, UNKNOWN};
use crate::stage::map::inflate::{cost_table, radius_cells};

/// Cells around true borders that are left out: none (strict), one, two (a ring of 0.1 m).
pub const MARGINS: usize = 3;

/// How far from a true obstacle a lethal cell is one that lies too near, cells.
const TOO_NEAR_CELLS: usize = 4;

const LETHAL: u8 = 254;
const NO_INFORMATION: u8 = 255;

/// The true map on a costmap's window, inflated by the costmap's own law.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueWindow {
    width: usize,
    /// Codes of [`crate::sim::truth`] by cell, row 0 = smallest y.
    pub cells: Vec<i8>,
    /// Costs as a perfect map would publish them.
    pub costs: Vec<u8>,
    /// How many cells each cell of cost 0 lies off the next true cost above 0, up to [`MARGINS`]; 0: it has a cost itself.
    clearance: Vec<u8>,
}

impl TrueWindow {
    /// The part of the true map that lies in `window`; what lies outside is unknown.
    ///
    /// # Errors
    /// [`Error::Input`] where the cells of both maps do not coincide.
    pub fn new(truth: &TruthFrame, window: &Grid, config: &Config) -> Result<Self> {
        let cells = resample(truth, window)?;
        let width = window.width as usize;
        let reach = inflated(&cells, width, config);
        let costs = cells.iter().zip(&reach).map(|(&cell, &cost)| published(cell, cost)).collect();
        Ok(Self { width, clearance: clearance(&reach, width), cells, costs })
    }

    /// Whether a cell is in F_gt when cells within `margin` of a true border are left out.
    fn is_free(&self, cell: usize, margin: usize) -> bool {
        self.cells[cell] == FREE && usize::from(self.clearance[cell]) > margin
    }

    /// Cells of F_gt within a radius of a cell, those beside a true border left out.
    pub fn free_within(&self, cell: usize, radius: usize) -> u16 {
        let height = self.cells.len() / self.width;
        let (x, y) = (cell % self.width, cell / self.width);
        let mut count = 0;
        for row in y.saturating_sub(radius)..=(y + radius).min(height - 1) {
            for column in x.saturating_sub(radius)..=(x + radius).min(self.width - 1) {
                let near = row.abs_diff(y).pow(2) + column.abs_diff(x).pow(2) <= radius * radius;
                count += u16::from(near && self.is_free(row * self.width + column, 1));
            }
        }
        count
    }

    /// Whether `test` holds for the cell or one within `reach` cells along both axes.
    fn near(&self, cell: usize, reach: usize, test: impl Fn(usize) -> bool) -> bool {
        let height = self.cells.len() / self.width;
        let (x, y) = (cell % self.width, cell / self.width);
        let rows = y.saturating_sub(reach)..=(y + reach).min(height - 1);
        rows.flat_map(|row| {
            let columns = x.saturating_sub(reach)..=(x + reach).min(self.width - 1);
            columns.map(move |column| row * self.width + column)
        })
        .any(test)
    }
}

fn resample(truth: &TruthFrame, window: &Grid) -> Result<Vec<i8>> {
    let grid = &truth.grid;
    let misfit = |reason: String| Error::Input { what: "true map".into(), reason };
    if (grid.resolution_m - window.resolution_m).abs() > 1e-9 {
        let (true_m, map_m) = (grid.resolution_m, window.resolution_m);
        return Err(misfit(format!("has cells of {true_m} m, the costmap of {map_m} m (`resolution_m`)")));
    }
    let offset = |from_m: f64, to_m: f64| -> Result<i64> {
        let cells = (from_m - to_m) / grid.resolution_m;
        if !(cells.abs() < 1e9 && (cells - cells.round()).abs() < 1e-3) {
            return Err(misfit("has cells that lie across those of the costmap".into()));
        }
        #[expect(clippy::cast_possible_truncation, reason = "checked to be below 1e9")]
        let cells = cells.round() as i64;
        Ok(cells)
    };
    let dx = offset(window.origin_x_m, grid.origin_x_m)?;
    let dy = offset(window.origin_y_m, grid.origin_y_m)?;
    let at = |x: i64, y: i64| {
        let inside = (0..i64::from(grid.width)).contains(&x) && (0..i64::from(grid.height)).contains(&y);
        let index = usize::try_from(y * i64::from(grid.width) + x).ok().filter(|_| inside);
        index.and_then(|index| truth.cells.get(index)).copied().unwrap_or(UNKNOWN)
    };
    let rows = 0..i64::from(window.height);
    Ok(rows.flat_map(|y| (0..i64::from(window.width)).map(move |x| at(x + dx, y + dy))).collect())
}

fn is_obstacle(cell: i8) -> bool {
    cell == OCCUPIED || cell == GLASS
}

/// Cost of every cell by its distance to the next true obstacle, glass included; 0 beyond the radius.
fn inflated(cells: &[i8], width: usize, config: &Config) -> Vec<u8> {
    let (table, radius) = (cost_table(config), i64::from(radius_cells(config)));
    let side = |count: usize| i64::try_from(count).unwrap_or(0);
    let (columns, rows) = (side(width), side(cells.len() / width.max(1)));
    let mut costs = vec![0_u8; cells.len()];
    for (index, _) in (0..).zip(cells).filter(|(_, cell)| is_obstacle(**cell)) {
        let (x, y) = (index % columns, index / columns);
        for row in (y - radius).max(0)..=(y + radius).min(rows - 1) {
            for column in (x - radius).max(0)..=(x + radius).min(columns - 1) {
                let squared = (column - x).pow(2) + (row - y).pow(2);
                let cost = usize::try_from(squared).ok().and_then(|squared| table.get(squared));
                let cell = usize::try_from(row * columns + column).unwrap_or(0);
                let cost = cost.and_then(|&cost| u8::try_from(cost).ok()).unwrap_or(0);
                costs[cell] = costs[cell].max(cost);
            }
        }
    }
    costs
}

/// As the costmap does: unknown is overwritten only from 253 up.
fn published(cell: i8, cost: u8) -> u8 {
    if cell == UNKNOWN && cost < 253 { NO_INFORMATION } else { cost }
}

fn clearance(costs: &[u8], width: usize) -> Vec<u8> {
    let far = u8::try_from(MARGINS).unwrap_or(u8::MAX);
    let mut clearance: Vec<u8> = costs.iter().map(|&cost| if cost > 0 { 0 } else { far }).collect();
    let height = costs.len() / width.max(1);
    for distance in 1..far {
        let before = clearance.clone();
        for (cell, value) in clearance.iter_mut().enumerate().filter(|(_, value)| **value == far) {
            let (x, y) = (cell % width, cell / width);
            let mut rows = y.saturating_sub(1)..=(y + 1).min(height - 1);
            let touches = rows.any(|row| {
                let row = &before[row * width..(row + 1) * width];
                row[x.saturating_sub(1)..=(x + 1).min(width - 1)].iter().any(|&near| near + 1 == distance)
            });
            if touches {
                *value = distance;
            }
        }
    }
    clearance
}

/// Counts over the cells of one frame or many, for one method.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MapTally {
    /// Cells of F_gt, by the margin that is left out around true borders.
    pub free: [u64; MARGINS],
    /// Of these, cells of cost 1 to 254.
    pub free_called_occupied: [u64; MARGINS],
    /// Of these, cells of cost 0.
    pub free_called_free: [u64; MARGINS],
    /// True obstacle cells before inflation, glass apart.
    pub solid: u64,
    /// Of these, lethal ones.
    pub solid_lethal: u64,
    /// Of these, cells that are lethal or have a lethal neighbour.
    pub solid_near_lethal: u64,
    /// True obstacle cells without a lethal cell in or beside them, glass apart, that are unknown.
    pub missed_unknown: u64,
    /// The same, called free or near an obstacle.
    pub missed_known: u64,
    /// Lethal cells that are truly free, within four cells of a true obstacle.
    pub lethal_too_near: u64,
    /// The same, farther from any.
    pub lethal_in_the_open: u64,
    /// Cells with glass alone.
    pub glass: u64,
    /// Of these, lethal ones.
    pub glass_lethal: u64,
}

impl MapTally {
    /// Adds a costmap on the window of `truth`.
    ///
    /// # Errors
    /// [`Error::Input`] where it has another number of cells.
    pub fn observe(&mut self, costmap: &[u8], truth: &TrueWindow) -> Result<()> {
        if costmap.len() != truth.cells.len() {
            let reason = format!("has {} cells for {} true ones", costmap.len(), truth.cells.len());
            return Err(Error::Input { what: "costmap".into(), reason });
        }
        let is_lethal = |cell: usize| costmap[cell] == LETHAL;
        for (cell, &cost) in costmap.iter().enumerate() {
            for margin in (0..MARGINS).filter(|&margin| truth.is_free(cell, margin)) {
                self.free[margin] += 1;
                self.free_called_occupied[margin] += u64::from((1..=LETHAL).contains(&cost));
                self.free_called_free[margin] += u64::from(cost == 0);
            }
            match truth.cells[cell] {
                FREE if is_lethal(cell) => {
                    let near = truth.near(cell, TOO_NEAR_CELLS, |other| is_obstacle(truth.cells[other]));
                    self.lethal_too_near += u64::from(near);
                    self.lethal_in_the_open += u64::from(!near);
                }
                OCCUPIED => {
                    let near = truth.near(cell, 1, is_lethal);
                    self.solid += 1;
                    self.solid_lethal += u64::from(is_lethal(cell));
                    self.solid_near_lethal += u64::from(near);
                    self.missed_unknown += u64::from(!near && cost == NO_INFORMATION);
                    self.missed_known += u64::from(!near && cost != NO_INFORMATION);
                }
                GLASS => {
                    self.glass += 1;
                    self.glass_lethal += u64::from(is_lethal(cell));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Adds the counts of another.
    pub fn add(&mut self, other: &Self) {
        for margin in 0..MARGINS {
            self.free[margin] += other.free[margin];
            self.free_called_occupied[margin] += other.free_called_occupied[margin];
            self.free_called_free[margin] += other.free_called_free[margin];
        }
        self.solid += other.solid;
        self.solid_lethal += other.solid_lethal;
        self.solid_near_lethal += other.solid_near_lethal;
        self.missed_unknown += other.missed_unknown;
        self.missed_known += other.missed_known;
        self.lethal_too_near += other.lethal_too_near;
        self.lethal_in_the_open += other.lethal_in_the_open;
        self.glass += other.glass;
        self.glass_lethal += other.glass_lethal;
    }

    /// FOR: share of the true free cells that are called occupied.
    pub fn false_occupied_rate(&self, margin: usize) -> Option<f64> {
        share(self.free_called_occupied[margin], self.free[margin])
    }

    /// FSR: share of the true free cells that are called free.
    pub fn free_space_recall(&self, margin: usize) -> Option<f64> {
        share(self.free_called_free[margin], self.free[margin])
    }

    /// OR: share of the true obstacle cells that are lethal, glass apart.
    pub fn obstacle_recall(&self) -> Option<f64> {
        share(self.solid_lethal, self.solid)
    }

    /// As OR, where a lethal neighbour counts too.
    pub fn near_obstacle_recall(&self) -> Option<f64> {
        share(self.solid_near_lethal, self.solid)
    }

    /// What most of its wrong cells are, in words, with their number as a share of the true obstacle cells; `None` without any.
    pub fn largest_loss(&self) -> Option<(&'static str, f64)> {
        let losses = [
            ("lethal up to 0.2 m before a true obstacle", self.lethal_too_near),
            ("lethal in the open", self.lethal_in_the_open),
            ("obstacles left unknown", self.missed_unknown),
            ("obstacles called free", self.missed_known),
        ];
        let (what, cells) =
            losses.into_iter().max_by_key(|(_, cells)| *cells).filter(|(_, cells)| *cells > 0)?;
        Some((what, share(cells, self.solid)?))
    }

    /// As OR, for cells with glass alone.
    pub fn glass_recall(&self) -> Option<f64> {
        share(self.glass_lethal, self.glass)
    }
}
