//! Mirror images in a glossy floor (spec 6 §2), of single returns placed by ring.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use limpid::Config;
use limpid::sensor::BeamGrid;

/// A scan as its grid has it: of each cell the least range in centimetres.
pub(crate) struct Cells<'a> {
    grid: &'a BeamGrid,
    config: &'a Config,
    centimetres: Vec<Option<u32>>,
}

impl<'a> Cells<'a> {
    /// Of points with their rings.
    pub(crate) fn new(grid: &'a BeamGrid, config: &'a Config, points: &[(DVec3, usize)]) -> Self {
        let mut cells = Self { grid, config, centimetres: vec![None; grid.cells() as usize] };
        for &(at, ring) in points {
            let cell = cells.number(cells.column(at), grid.ring_rows[ring] as usize);
            let range = (at.length() * 100.0) as u32;
            let kept = &mut cells.centimetres[cell];
            *kept = Some(kept.map_or(range, |kept| kept.min(range)));
        }
        cells
    }

    fn number(&self, column: usize, row: usize) -> usize {
        column % self.grid.columns as usize * self.grid.rows as usize + row
    }

    fn column(&self, at: DVec3) -> usize {
        let columns = self.grid.columns as usize;
        ((at.y.atan2(at.x) / TAU + 1.0) * columns as f64).round() as usize % columns
    }

    fn range_m(&self, column: usize, row: usize) -> Option<f64> {
        self.centimetres[self.number(column, row)].map(|range| f64::from(range) / 100.0)
    }

    /// Whether a surface lies at a place, ranges that differ by less than `near_m` being the same, and whether the scan looks past it:
    /// all around it that is measured lies farther, and enough is; and whether anything is measured there.
    pub(crate) fn shown(&self, at: DVec3, near_m: f64) -> [bool; 3] {
        let share = at.z.atan2(at.truncate().length()) / PI + 0.5;
        let bin = (share * 2048.0).clamp(0.0, 2047.0) as usize;
        let row = self.grid.elevation_rows[bin];
        if row >= self.grid.rows {
            return [false; 3];
        }
        let (column, rows) = (self.column(at), row.saturating_sub(1)..(row + 2).min(self.grid.rows));
        let columns = self.grid.columns as usize;
        let around =
            (0..3).flat_map(|k| rows.clone().map(move |row| (column + columns - 1 + k, row as usize)));
        let measured: Vec<f64> = around.filter_map(|(column, row)| self.range_m(column, row)).collect();
        let here = self.range_m(column, row as usize).is_some();
        let matches = measured.iter().any(|range_m| (range_m - at.length()).abs() < near_m);
        let beyond =
            here && measured.len() >= 4 && measured.iter().all(|range_m| *range_m > at.length() + near_m);
        [matches, beyond, !measured.is_empty()]
    }

    /// How much ranges may differ at a place and be the same.
    pub(crate) fn tolerance_m(&self, at: DVec3) -> f64 {
        self.config.glass_match_m + self.config.glass_match_per_m * at.length()
    }

    fn looks_past(&self, at: DVec3) -> bool {
        self.shown(at, self.tolerance_m(at))[1]
    }

    /// Whether a point is an image in a floor that lies level `eye_m` below the lidar.
    pub(crate) fn is_image(&self, at: DVec3, ring: usize, eye_m: f64) -> bool {
        let below = |height: f64, range_m: f64| height < -(0.1 + 0.01 * range_m);
        let (height, falls) = (eye_m + at.z, -at.z / at.length());
        if !below(height, at.length()) {
            return false;
        }
        let columns = self.grid.columns as usize;
        let reach = (columns / 300).clamp(4, 16);
        let (column, row) = (self.column(at), self.grid.ring_rows[ring] as usize);
        let (mut floor, mut deep) = (0, 0);
        for k in 0..=2 * reach {
            let Some(range_m) = self.range_m(column + columns - reach + k, row) else { continue };
            let height = eye_m - falls * range_m;
            floor += usize::from(height.abs() < 0.05 + 0.005 * range_m);
            deep += usize::from(below(height, range_m));
        }
        floor >= 2 && deep >= 4 && !self.looks_past(at - DVec3::Z * (2.0 * height))
    }
}
