//! The grid of a sensor's beams, taken from a scan: rows by elevation, columns by azimuth (spec 3 §1).

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::base::{Error, Result};
use crate::sensor::{Point, Scan, has_steady_rings};

/// Bins over 180 degrees in which elevations are looked up (`ELEVATION_BINS`).
const ELEVATION_BINS: u32 = 2048;
/// No row.
const NONE: u32 = u32::MAX;
/// Most rows.
const MOST_ROWS: usize = 512;
/// Rows of a cloud without rings.
const ROWS_WITHOUT_RINGS: u16 = 64;
/// Fewest and most columns.
const COLUMNS: [f64; 2] = [90.0, 4096.0];
/// Columns where a scan does not tell.
const USUAL_COLUMNS: f64 = 1024.0;
/// Azimuths closer than this are of one firing, radians.
const SAME_AZIMUTH: f64 = 1e-4;
/// A direction belongs to the row nearest to it, up to this many steps of elevation off.
const ROW_REACH: f64 = 0.75;

/// Rows and columns of a sensor's beams.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamGrid {
    /// Rows, the lowest first.
    pub rows: u32,
    /// Columns of one revolution.
    pub columns: u32,
    /// Row of each ring number; `u32::MAX` for numbers without points. One element where there are no rings.
    pub ring_rows: Vec<u32>,
    /// Row of each bin of elevation from -90 to 90 degrees; `u32::MAX` where no beam goes.
    pub elevation_rows: Vec<u32>,
    /// Row nearest the horizontal.
    pub level_row: u32,
    /// Whether points are placed by their rings.
    pub by_ring: bool,
    /// Median angle between rows, radians.
    pub row_step_rad: f64,
}

impl BeamGrid {
    /// From a scan: rings and their mean elevations, or 64 rows of equal angle where it has no rings of steady elevation; columns from the
    /// median step of azimuth.
    ///
    /// # Errors
    /// [`Error::Decode`] where the scan has no usable point or too many rings.
    pub fn of_scan(scan: &Scan) -> Result<Self> {
        let points: Vec<&Point> = scan.points.iter().filter(|point| is_usable(point)).collect();
        if points.is_empty() {
            return Err(bad("has no usable point"));
        }
        let by_ring = points.iter().any(|point| point.ring != Point::UNKNOWN) && has_steady_rings(scan);
        let (ring_rows, elevations) =
            if by_ring { ring_elevations(&points)? } else { (vec![NONE], even_elevations(&points)) };
        let row_step_rad = median_step(&elevations);
        let level = elevations.iter().enumerate().min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
        Ok(Self {
            rows: count(elevations.len()),
            columns: columns(&points, by_ring),
            ring_rows,
            elevation_rows: elevation_rows(&elevations, row_step_rad),
            level_row: level.map_or(0, |(row, _)| count(row)),
            by_ring,
            row_step_rad,
        })
    }

    /// Cells, each of two returns.
    pub fn cells(&self) -> u32 {
        self.rows * self.columns
    }

    /// Rows and columns that lie within an angle to one side, at least one.
    pub fn cells_within(&self, angle_deg: f64) -> [u32; 2] {
        let steps = |step_rad: f64| {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "at most 16 and at least 1"
            )]
            let steps = (angle_deg.to_radians() / step_rad).round().clamp(1.0, 16.0) as u32;
            steps
        };
        [steps(self.row_step_rad), steps(TAU / f64::from(self.columns))]
    }
}

fn is_usable(point: &Point) -> bool {
    let [x, y, z] = point.position_m();
    x.is_finite() && y.is_finite() && z.is_finite() && x.hypot(y) > 1e-3
}

fn elevation(point: &Point) -> f64 {
    f64::from(point.z_m).atan2(f64::from(point.x_m).hypot(f64::from(point.y_m)))
}

/// Row of every ring, and the mean elevation of every row, ascending.
fn ring_elevations(points: &[&Point]) -> Result<(Vec<u32>, Vec<f64>)> {
    let mut sums: Vec<(f64, f64)> = Vec::new();
    for point in points.iter().filter(|point| point.ring != Point::UNKNOWN) {
        let ring = usize::from(point.ring);
        if ring >= MOST_ROWS {
            return Err(bad(&format!("has ring {ring}; at most {MOST_ROWS} rings are supported")));
        }
        if sums.len() <= ring {
            sums.resize(ring + 1, (0.0, 0.0));
        }
        sums[ring].0 += elevation(point);
        sums[ring].1 += 1.0;
    }
    let rings = sums.iter().enumerate().filter(|(_, sum)| sum.1 > 0.0);
    let mut rings: Vec<(usize, f64)> = rings.map(|(ring, sum)| (ring, sum.0 / sum.1)).collect();
    rings.sort_by(|a, b| a.1.total_cmp(&b.1));
    let mut rows = vec![NONE; sums.len()];
    for (row, (ring, _)) in rings.iter().enumerate() {
        rows[*ring] = count(row);
    }
    Ok((rows, rings.into_iter().map(|(_, elevation)| elevation).collect()))
}

/// Evenly from the lowest to the highest point.
fn even_elevations(points: &[&Point]) -> Vec<f64> {
    let ends = points.iter().map(|point| elevation(point));
    let (low, high) = ends.fold((FRAC_PI_2, -FRAC_PI_2), |(low, high), e| (low.min(e), high.max(e)));
    let step = (high - low).max(1e-3) / f64::from(ROWS_WITHOUT_RINGS);
    (0..ROWS_WITHOUT_RINGS).map(|row| low + (f64::from(row) + 0.5) * step).collect()
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

fn median_step(ascending: &[f64]) -> f64 {
    median(ascending.windows(2).map(|pair| pair[1] - pair[0]).collect()).unwrap_or(0.03).max(1e-3)
}

fn elevation_rows(elevations: &[f64], row_step_rad: f64) -> Vec<u32> {
    let nearest = |bin: u32| {
        let angle = (f64::from(bin) + 0.5) * PI / f64::from(ELEVATION_BINS) - FRAC_PI_2;
        let off = |elevation: &f64| (elevation - angle).abs();
        let row = elevations.iter().enumerate().min_by(|a, b| off(a.1).total_cmp(&off(b.1)));
        row.filter(|(_, elevation)| off(elevation) <= ROW_REACH * row_step_rad)
            .map_or(NONE, |(row, _)| count(row))
    };
    (0..ELEVATION_BINS).map(nearest).collect()
}

/// From the median step of azimuth within rings.
fn columns(points: &[&Point], by_ring: bool) -> u32 {
    let mut azimuths: Vec<(u16, f64)> = Vec::with_capacity(points.len());
    if by_ring {
        azimuths.extend(points.iter().map(|p| (p.ring, f64::from(p.y_m).atan2(f64::from(p.x_m)))));
    }
    azimuths.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let pairs = azimuths.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    let steps = pairs.map(|pair| pair[1].1 - pair[0].1).filter(|step| *step > SAME_AZIMUTH);
    let columns = median(steps.collect()).map_or(USUAL_COLUMNS, |step| (TAU / step).round());
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let columns = columns.clamp(COLUMNS[0], COLUMNS[1]) as u32;
    columns
}

fn count(value: usize) -> u32 {
    u32::try_from(value).unwrap_or(NONE)
}

fn bad(reason: &str) -> Error {
    Error::Decode { what: "scan".into(), reason: reason.into() }
}
