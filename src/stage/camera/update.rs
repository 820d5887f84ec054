//! Occupancy and state per cell (spec 1 §3), temporal rejection (spec 1 §4), and the occupancy layer of the map (spec 4 §1): when,
//! by whom and how each cell was last seen by a camera.

use std::sync::Arc;

use glam::{DVec2, Vec2};

use crate::base::Result;
use crate::config::{Config, Method};
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::map::Clock;
use crate::sensor::CameraModel;
use crate::stage::map::layers::Layers;
use crate::stage::{CameraJob, Moment, Stage, single};

/// The pass, by the mean of the weights.
pub const UPDATE: ShaderSource = ShaderSource {
    name: "update",
    parts: &[
        include_str!("../../../shaders/lib/cell.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/weight.wgsl"),
        include_str!("../../../shaders/lib/record.wgsl"),
        include_str!("../../../shaders/lib/fusion/mean.wgsl"),
        include_str!("../../../shaders/update.wgsl"),
    ],
};

/// The pass, by evidence that counts trust (spec 1 §9).
pub const UPDATE_BY_EVIDENCE: ShaderSource = ShaderSource {
    name: "update",
    parts: &[
        include_str!("../../../shaders/lib/cell.wgsl"),
        include_str!("../../../shaders/lib/evidence.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/weight.wgsl"),
        include_str!("../../../shaders/lib/record.wgsl"),
        include_str!("../../../shaders/lib/fusion/strength.wgsl"),
        include_str!("../../../shaders/lib/fusion/evidence.wgsl"),
        include_str!("../../../shaders/update.wgsl"),
    ],
};

/// Frame rate for which lambda is stated (spec 1 §3).
const NOMINAL_RATE_HZ: f64 = 30.0;

/// n0 of spec 1 §9 at a distance of 1 m, over the square of the focal length in pixels.
const HITS_BY_SQUARED_FOCAL: f64 = 7.5e-5;

/// Least logarithm of lambda: what it leaves of any occupancy after one tick is 0 in f32.
const LEAST_LOG2: f64 = -1000.0;

crate::params! {
    /// Parameters of `update`.
    pub struct UpdateParams {
        /// Cells along a side.
        pub side: u32,
        /// Slot of window cell (0, 0) along x.
        pub origin_slot_x: u32,
        /// Slot of window cell (0, 0) along y.
        pub origin_slot_y: u32,
        /// Pixels that make a hit.
        pub min_hits: u32,
        /// K.
        pub confirmations: u32,
        /// Observed frames looked at.
        pub temporal_window: u32,
        /// Hits needed among them.
        pub temporal_hits: u32,
        /// Share of the old occupancy kept.
        pub lambda: f32,
        /// Occupancy at which a cell becomes occupied.
        pub occupied_threshold: f32,
        /// Occupancy under which it stops being so.
        pub free_threshold: f32,
        /// Fixed-point one of weights.
        pub weight_scale: f32,
        /// Unused.
        pub pad: u32,
    }
}

crate::params! {
    /// Parameters of the marks, beside those of `update`.
    pub struct CellMarksParams {
        /// Tick of the frame.
        pub tick: u32,
        /// The camera's number among the sensors, + 1.
        pub sensor: u32,
        /// Logarithm of the share of the old occupancy that a tick leaves, where it counts by time.
        pub log2_lambda_per_tick: f32,
        /// Unused.
        pub pad: u32,
    }
}

crate::params! {
    /// Parameters of evidence that counts trust, beside those of `update`.
    pub struct EvidenceParams {
        /// Camera in the window.
        pub camera_xy_m: Vec2,
        /// Side of a cell.
        pub resolution_m: f32,
        /// n0 at a distance of 1 m.
        pub hits_at_1_m: f32,
        /// n0 at least.
        pub least_hits: f32,
        /// Exponent of the hits' quality.
        pub exponent: f32,
        /// Share of a look that a tick allows, where looks count by time.
        pub looks_per_tick: f32,
        /// Unused.
        pub pad: u32,
    }
}

/// The parameters of evidence for one frame of a camera at `camera_xy_m` in the window.
pub fn evidence_params(config: &Config, camera: &CameraModel, camera_xy_m: DVec2) -> EvidenceParams {
    EvidenceParams {
        camera_xy_m: camera_xy_m.as_vec2(),
        resolution_m: single(config.resolution_m),
        hits_at_1_m: single(HITS_BY_SQUARED_FOCAL * camera.fx * camera.fy),
        least_hits: single(config.evidence_least_hits),
        exponent: single(config.evidence_exponent),
        looks_per_tick: single(Clock::TICK_S * NOMINAL_RATE_HZ),
        pad: 0,
    }
}

/// The parameters of the marks for one frame of the sensor of that number, counted from 0, where `lambda` is stated for 30 Hz.
pub fn mark_params(tick: u32, sensor: u32, lambda: f64) -> CellMarksParams {
    let log2_lambda_per_tick = single((lambda.log2() * Clock::TICK_S * NOMINAL_RATE_HZ).max(LEAST_LOG2));
    CellMarksParams { tick, sensor: sensor + 1, log2_lambda_per_tick, pad: 0 }
}

/// Declares the layer and the grids of a frame, and appends the pass. `timed`: the old occupancy counts less the longer ago it is
/// (`rate_independent`, or several cameras); `lowest`: `back_project` keeps the lowest hits.
///
/// # Errors
/// From the plan.
pub fn declare(plan: &mut Plan, job: &CameraJob, timed: bool, lowest: bool) -> Result<()> {
    Layers { cameras: true, ..Layers::default() }.declare(plan, job.map.side)?;
    plan.uniform::<CellMarksParams>("cell_marks_params")?;
    plan.uniform::<UpdateParams>("update_params")?;
    for grid in ["evidence", "occupancy", "state"] {
        plan.product(grid, job.grid_bytes(4))?;
    }
    let pass = if job.counts_trust() {
        plan.uniform::<EvidenceParams>("evidence_params")?;
        UPDATE_BY_EVIDENCE
    } else {
        UPDATE
    };
    plan.step(pass, Invocations::area(job.map.side, job.map.side), &[])?;
    plan.with(&[("weighted", job.weighted()), ("gated", job.gated())])?;
    plan.with(&[("timed", timed), ("lowest", lowest), ("keep_grids", job.layers)])
}

/// The parameters of a frame with that share of the old occupancy kept.
pub fn params(job: &CameraJob, [origin_slot_x, origin_slot_y]: [u32; 2], lambda: f64) -> UpdateParams {
    let config = &job.config;
    let temporal = config.method == Method::Temporal;
    UpdateParams {
        side: job.map.side,
        origin_slot_x,
        origin_slot_y,
        min_hits: config.min_hits,
        confirmations: config.confirmations,
        temporal_window: if temporal { config.temporal_window } else { 1 },
        temporal_hits: if temporal { config.temporal_hits } else { 1 },
        lambda: single(lambda),
        occupied_threshold: single(config.occupied_threshold),
        free_threshold: single(config.free_threshold),
        weight_scale: job.weight_scale(),
        pad: 0,
    }
}

/// The stage.
#[derive(Debug)]
pub struct Update {
    /// What it is built for.
    pub job: Arc<CameraJob>,
}

impl Stage for Update {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        declare(plan, &self.job, self.job.counts_by_time(), self.job.keeps_lowest())
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let (job, lambda) = (&self.job, self.job.config.lambda);
        input.set("update_params", &params(job, moment.window.origin_slot(job.map.side), lambda))?;
        if job.counts_trust() {
            let camera = moment.in_window(moment.pose.map_from_sensor(), 0.0).translation_m.truncate();
            input.set("evidence_params", &evidence_params(&job.config, &job.depth, camera))?;
        }
        input.set("cell_marks_params", &mark_params(moment.tick, job.sensor, lambda))
    }
}
