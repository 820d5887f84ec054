//! Solid, passable, transparent, free and unknown cells (spec 2 §3), and the solidity layer of the map (spec 4 §1): the classes
//! of a scan's cells, kept until a scan says something else of them.
//!
//! Where the map has cameras too, a free cell keeps between which heights beams crossed it: the pass over points then leaves how
//! far beams reached, by sector and slope.

use std::sync::Arc;

use glam::{Vec2, Vec4};

use crate::base::Result;
use crate::config::LayerMeasure;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::stage::lidar::Placed;
use crate::stage::lidar::intensity_layers::{HEIGHTS, heights};
use crate::stage::map::layers::Layers;
use crate::stage::{LidarJob, Moment, Stage, single};

const SCAN: &str = include_str!("../../../shaders/lib/scan.wgsl");
const SLOT: &str = include_str!("../../../shaders/lib/slot.wgsl");
const RECORD: &str = include_str!("../../../shaders/lib/record.wgsl");
const BINS: &str = include_str!("../../../shaders/lib/crossing/bins.wgsl");
const ACROSS: &str = include_str!("../../../shaders/lib/crossing/across.wgsl");
const ACROSS_NONE: &str = include_str!("../../../shaders/lib/crossing/across_none.wgsl");
const BY_VALUE: &str = include_str!("../../../shaders/lib/solidity/by_value.wgsl");
const BY_MODEL: &str = include_str!("../../../shaders/lib/solidity/by_model.wgsl");
const PASS: &str = include_str!("../../../shaders/intensity_classes.wgsl");

/// The pass, in a map of lidars alone.
pub const INTENSITY_CLASSES: ShaderSource =
    ShaderSource { name: "intensity_classes", parts: &[SCAN, SLOT, RECORD, ACROSS_NONE, BY_VALUE, PASS] };

/// The pass, in a map with cameras.
pub const INTENSITY_CLASSES_AND_BEAMS: ShaderSource =
    ShaderSource { name: "intensity_classes", parts: &[SCAN, SLOT, RECORD, BINS, ACROSS, BY_VALUE, PASS] };

/// The pass with learned solidity, in a map of lidars alone.
pub const INTENSITY_CLASSES_LEARNED: ShaderSource =
    ShaderSource { name: "intensity_classes", parts: &[SCAN, SLOT, RECORD, ACROSS_NONE, BY_MODEL, PASS] };

/// The pass with learned solidity, in a map with cameras.
pub const INTENSITY_CLASSES_LEARNED_AND_BEAMS: ShaderSource =
    ShaderSource { name: "intensity_classes", parts: &[SCAN, SLOT, RECORD, BINS, ACROSS, BY_MODEL, PASS] };

crate::params! {
    /// Parameters of `intensity_classes`.
    pub struct IntensityClassesParams {
        /// Bounds of the tall layers.
        pub heights: [Vec4; HEIGHTS],
        /// The lidar in the window.
        pub lidar: Vec2,
        /// Cells along a side.
        pub side: u32,
        /// Tall layers.
        pub tall: u32,
        /// Slot of window cell (0, 0) along x.
        pub origin_slot_x: u32,
        /// Slot of window cell (0, 0) along y.
        pub origin_slot_y: u32,
        /// Side of a cell.
        pub resolution_m: f32,
        /// Gamma.
        pub gamma: f32,
        /// Excess of the plane z = 0 from which a cell is transparent.
        pub transparent_threshold: f32,
        /// Value of a layer that counts fully.
        pub solid_value: f32,
        /// Share of a remembered value that is kept.
        pub keep_share: f32,
        /// Returns under which a cell is undecided.
        pub min_returns: u32,
        /// Firings per radian of azimuth.
        pub rays_per_rad: f32,
        /// Rings per radian of elevation.
        pub rings_per_rad: f32,
        /// Elevation of the lowest ring, radians.
        pub elevation_low: f32,
        /// Elevation of the highest ring, radians.
        pub elevation_high: f32,
        /// Cells that the window moved along x since the scan before.
        pub shift_x: i32,
        /// Cells that it moved along y.
        pub shift_y: i32,
        /// 1: nothing is remembered.
        pub forget: u32,
        /// 1: a layer with any intensity counts fully, as only what stands has some.
        pub standing: u32,
    }
}

crate::params! {
    /// Parameters of the layer, beside those of `intensity_classes`.
    pub struct SolidCellsParams {
        /// Tick of the scan.
        pub tick: u32,
        /// The lidar's number among the sensors, + 1.
        pub sensor: u32,
        /// Height of the lidar above the stated ground.
        pub lidar_height_m: f32,
        /// Unused.
        pub pad: u32,
    }
}

/// The parameters of the layer for one scan of the sensor of that number, counted from 0.
pub fn layer_params(tick: u32, sensor: u32, lidar_height_m: f32) -> SolidCellsParams {
    SolidCellsParams { tick, sensor: sensor + 1, lidar_height_m, pad: 0 }
}

/// Value of a layer that counts fully: full scale in each return, and for the sum one such return in the cell.
pub fn solid_value(job: &LidarJob) -> f64 {
    match job.config.layer_measure {
        LayerMeasure::Sum => job.config.scan_resolution_m.powi(-2),
        LayerMeasure::Mean | LayerMeasure::Expected => 1.0,
    }
}

/// Fades of remembered glass in one decay time: a remembered value of a single step still loses 256 units of its fraction in
/// each, so that rounding is below 1 %.
const FADES_PER_DECAY: f64 = 4096.0;

/// Share of a remembered value that is kept since the scan before.
///
/// A slow decay comes in fades at fixed times of the clock, none or several a scan: many scans in a short time then fade as
/// much as few.
fn keep_share(decay_s: f64, moment: &Moment<'_>) -> Result<f64> {
    let Some(dt_s) = moment.since_last_s.filter(|&dt_s| decay_s > 0.0 && dt_s > 0.0) else { return Ok(1.0) };
    let lost = dt_s / decay_s;
    if lost * FADES_PER_DECAY > 64.0 {
        return Ok((-lost).exp());
    }
    let now_s = std::time::Duration::from_nanos(moment.scan()?.stamp_ns).as_secs_f64();
    let fades = |at_s: f64| (at_s / decay_s * FADES_PER_DECAY).floor();
    Ok(((fades(now_s - dt_s) - fades(now_s)) / FADES_PER_DECAY).exp())
}

/// The parameters of one scan.
pub fn params(job: &LidarJob, moment: &Moment<'_>) -> Result<IntensityClassesParams> {
    let config = &job.config;
    let [origin_slot_x, origin_slot_y] = moment.window.origin_slot(job.map.side);
    let [shift_x, shift_y] = moment.own_window.shift;
    let per_rad = |step_deg: f64| single(1.0 / step_deg.to_radians().max(1e-9));
    let [low, high] = config.elevation_range_deg.map(|deg| single(deg.to_radians()));
    Ok(IntensityClassesParams {
        heights: heights(job),
        lidar: Placed::of(moment, job.deskew).lidar_in_window_m.as_vec2(),
        side: job.map.side,
        tall: job.tall_layers(),
        origin_slot_x,
        origin_slot_y,
        resolution_m: single(config.scan_resolution_m),
        gamma: if moment.standing { 0.0 } else { single(config.gamma_or_default()) },
        transparent_threshold: single(config.transparent_threshold),
        solid_value: single(solid_value(job)),
        keep_share: single(keep_share(config.transparent_decay_s, moment)?),
        min_returns: config.min_returns,
        rays_per_rad: per_rad(config.azimuth_step_deg),
        rings_per_rad: per_rad(config.elevation_step_deg),
        elevation_low: low,
        elevation_high: high,
        shift_x,
        shift_y,
        forget: u32::from(moment.own_window.forget),
        standing: u32::from(moment.standing),
    })
}

/// Declares the layer and the buffers of the pass, and appends it; `cameras`: whether the map has some.
///
/// # Errors
/// From the plan.
pub fn declare(plan: &mut Plan, job: &LidarJob, cameras: bool) -> Result<()> {
    Layers { lidars: true, ..Layers::default() }.declare(plan, job.map.side)?;
    plan.uniform::<SolidCellsParams>("solid_cells_params")?;
    plan.uniform::<IntensityClassesParams>("intensity_classes_params")?;
    plan.product("obstacle_value", job.grid_bytes(4))?;
    plan.state("remembered", job.grid_bytes(4))?;
    plan.product("layer_values", job.grid_bytes(4 * u64::from(job.layer_count())))?;
    let pass = match (job.solidity.is_some(), cameras) {
        (false, false) => INTENSITY_CLASSES,
        (false, true) => INTENSITY_CLASSES_AND_BEAMS,
        (true, false) => INTENSITY_CLASSES_LEARNED,
        (true, true) => INTENSITY_CLASSES_LEARNED_AND_BEAMS,
    };
    plan.step(pass, Invocations::area(job.map.side, job.map.side), &[])?;
    let measure = match job.config.layer_measure {
        LayerMeasure::Sum => 0_u32,
        LayerMeasure::Mean => 1,
        LayerMeasure::Expected => 2,
    };
    plan.with(&[("measure", measure)])?;
    plan.with(&[("clearing", job.config.transparent_clear > 0.0), ("keep_layers", job.layers)])
}

/// The stage.
#[derive(Debug)]
pub struct IntensityClasses {
    /// What it is built for.
    pub job: Arc<LidarJob>,
}

impl Stage for IntensityClasses {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        declare(plan, &self.job, self.job.map.layers.cameras)
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let height_m = moment.pose.map_from_sensor().translation_m.z - self.job.config.ground_z_m;
        input.set("intensity_classes_params", &params(&self.job, moment)?)?;
        input.set("solid_cells_params", &layer_params(moment.tick, self.job.sensor, single(height_m)))
    }
}
