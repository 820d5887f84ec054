//! Solid or passable by shape and by what beams do (spec 6 §3), whatever the scale of intensities, and without any.
//!
//! Three passes: what stands in each cell is counted, and the beams by direction; beams that ended before a cell are told from
//! those that went on behind it; a small model judges each cell by its counts and those around it. What the model calls
//! passable, `intensity_classes` does too; all else that stands is solid: cells with few returns around them, all cells where
//! the ground is not known, all of a scan that is too flat to show shapes, and all in
//! cells of a size that the model does not know.

mod brightness;
mod model;
mod shaders;

use std::sync::Arc;

use glam::Vec2;

pub use brightness::Trend;
pub use model::{HIDDEN, INPUTS, SHIPPED, SolidityModel};
pub use shaders::{ALL, BEAMS, COUNTS, COUNTS_OF_BUFFER, JUDGE};

use crate::base::Result;
use crate::config::Config;
use crate::gpu::{FrameInput, Invocations, Plan};
use crate::sensor::Scan;
use crate::stage::lidar::Placed;
use crate::stage::lidar::intensity_layers::{SECTORS, has_floor};
use crate::stage::{LidarJob, Moment, Stage, single};

/// Words of a cell's counts (`CELL_COUNTS` of `shaders/lib/solidity/params.wgsl`).
pub const CELL_COUNTS: u32 = 13;

/// Words of a block's (`BLOCK_COUNTS`).
pub const BLOCK_COUNTS: u32 = 5;

/// What lies this near a cell's centre counts as around it, metres; at most so many cells.
const REACH_M: f64 = 0.3;
const MOST_REACH: u32 = 6;

/// Sides of cells that the model knows, metres: in smaller or larger ones all is solid.
const SIDES_M: std::ops::RangeInclusive<f64> = 0.04..=0.25;

/// Side of a block, metres.
const BLOCK_M: f64 = 0.5;

/// Bins of slopes in a sector (`SLOPE_BINS` of `shaders/lib/crossing/bins.wgsl`), and words of each.
pub const SLOPE_BINS: u32 = 128;
pub const BIN_WORDS: u32 = 3;

/// Words of all bins, and of the sums of slopes behind them.
pub const BEAM_WORDS: u32 = SECTORS * SLOPE_BINS * BIN_WORDS + SLOPE_BINS;

/// Points of a scan whose elevation is looked at, at most.
const MOST_LOOKED_AT: usize = 1024;

/// Tangent of the elevations that the middle nine tenths of a scan's beams span at least: a scanner of one plane, or of a few,
/// shows no shapes.
const LEAST_SPAN: f64 = 0.1;

crate::params! {
    /// Parameters of all passes of learned solidity.
    pub struct SolidityParams {
        /// The lidar in the window.
        pub lidar: Vec2,
        /// Side of a cell.
        pub resolution_m: f32,
        /// Cells along a side.
        pub side: u32,
        /// What lies lower above the ground is floor.
        pub height_min_m: f32,
        /// What lies higher is over the robot.
        pub height_max_m: f32,
        /// Trend of log2 of intensity: at 1 m.
        pub bright_at_1m: f32,
        /// Its growth with log2 of range.
        pub bright_slope: f32,
        /// 1 / deviation from it; 0: intensities say nothing.
        pub bright_scale: f32,
        /// 1: the sensor gives two returns of a beam.
        pub two_returns: f32,
        /// 0: the scan is too flat.
        pub judged: u32,
        /// 1: a stated ground lies below the lidar.
        pub ground_stated: u32,
        /// Returns around a cell under which it is solid.
        pub least_returns: u32,
        /// Cells to each side that count as around a cell.
        pub reach_cells: u32,
        /// Side of a block, cells.
        pub block_cells: u32,
        /// Blocks along a side.
        pub blocks: u32,
    }
}

/// The whole number of cells nearest to a length, at least 1.
fn cells_in(length_m: f64, config: &Config) -> u32 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates; from 1 up")]
    let cells = (length_m / config.scan_resolution_m).round().max(1.0) as u32;
    cells
}

fn block_cells(config: &Config) -> u32 {
    cells_in(BLOCK_M, config)
}

/// Whether the beams of a scan span enough elevations to show shapes.
fn shows_shapes(scan: &Scan) -> bool {
    let stride = scan.points.len().div_ceil(MOST_LOOKED_AT).max(1);
    let tangent = |point: &crate::sensor::Point| f64::from(point.z_m) / f64::from(point.x_m.hypot(point.y_m));
    let mut tangents: Vec<f64> =
        scan.points.iter().step_by(stride).map(tangent).filter(|tangent| tangent.is_finite()).collect();
    tangents.sort_by(f64::total_cmp);
    let (low, high) = (tangents.len() / 20, tangents.len().saturating_sub(1 + tangents.len() / 20));
    low < high && tangents[high] - tangents[low] >= LEAST_SPAN
}

/// Invocations of the judging pass for a window of so many cells along a side: a workgroup of 64 for each square of 8 by 8, so that no
/// extent is too large for a dispatch.
pub fn judged_cells(side: u32) -> Invocations {
    Invocations([64 * side.div_ceil(8), side.div_ceil(8), 1])
}

/// The parameters of one scan.
///
/// # Errors
/// [`crate::Error::Plan`] where the moment is none of a scan.
pub fn params(job: &LidarJob, model: &SolidityModel, moment: &Moment<'_>) -> Result<SolidityParams> {
    let (scan, config) = (moment.scan()?, &job.config);
    let placed = Placed::of(moment, job.deskew);
    let trend = Trend::of(scan);
    let of_trend = |of: fn(&Trend) -> f64| trend.as_ref().map_or(0.0, |trend| single(of(trend)));
    Ok(SolidityParams {
        lidar: placed.lidar_in_window_m.as_vec2(),
        resolution_m: single(config.scan_resolution_m),
        side: job.map.side,
        height_min_m: single(config.height_min_m),
        height_max_m: single(config.height_max_m),
        bright_at_1m: of_trend(|trend| trend.at_1m),
        bright_slope: of_trend(|trend| trend.slope),
        bright_scale: of_trend(|trend| 1.0 / trend.deviation),
        two_returns: f32::from(u8::from(scan.points.iter().any(|point| point.return_type.is_of_two()))),
        judged: u32::from(shows_shapes(scan) && SIDES_M.contains(&config.scan_resolution_m)),
        ground_stated: u32::from(has_floor(config, placed.lidar_z_m)),
        least_returns: model.least_returns,
        reach_cells: cells_in(REACH_M, config).min(MOST_REACH),
        block_cells: block_cells(config),
        blocks: job.map.side.div_ceil(block_cells(config)),
    })
}

/// The stage.
#[derive(Debug)]
pub struct Solidity {
    /// What it is built for.
    pub job: Arc<LidarJob>,
    /// Its model.
    pub model: Arc<SolidityModel>,
}

impl Stage for Solidity {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let job = &self.job;
        let cells = Invocations::area(job.map.side, job.map.side);
        plan.uniform::<SolidityParams>("solidity_params")?;
        let blocks = u64::from(job.map.side.div_ceil(block_cells(&job.config)));
        let of_blocks = 4 * u64::from(BLOCK_COUNTS) * blocks * blocks;
        plan.zeroed("cell_counts", job.grid_bytes(4 * u64::from(CELL_COUNTS)) + of_blocks)?;
        plan.zeroed("beam_bins", 4 * u64::from(BEAM_WORDS))?;
        plan.scratch("cell_beams", job.grid_bytes(16))?;
        plan.fixed("solidity_weights", self.model.words())?;
        plan.zeroed("standing_cells", job.grid_bytes(4) + 4)?;
        plan.scratch("passable_cells", job.grid_bytes(4))?;
        let kept = if job.solidity_inputs { job.grid_bytes(4 * INPUTS.len() as u64) } else { 16 };
        plan.product("solidity_inputs", kept)?;
        let (pass, points) =
            if job.glass.is_some() { (COUNTS_OF_BUFFER, "clean_points") } else { (COUNTS, "points") };
        plan.step(pass, Invocations::line(job.capacity), &[("points", points)])?;
        plan.with(&[("deskewed", job.deskew)])?;
        plan.step(BEAMS, cells, &[])?;
        plan.with(&[("keep_inputs", job.solidity_inputs)])?;
        plan.step(JUDGE, judged_cells(job.map.side), &[])?;
        plan.with(&[("keep_inputs", job.solidity_inputs)])
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let points = u32::try_from(moment.scan()?.points.len()).unwrap_or(self.job.capacity);
        input.limit(COUNTS.name, Invocations::line(points))?;
        input.set("solidity_params", &params(&self.job, &self.model, moment)?)
    }
}
