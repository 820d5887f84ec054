//! Occupancy and state per cell (spec 1 §3), temporal rejection (spec 1 §4).

use crate::base::Result;
use crate::config::Method;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::stage::{Job, Moment, Stage, single};

/// The pass.
pub const UPDATE: ShaderSource = ShaderSource {
    name: "update",
    parts: &[
        include_str!("../../../shaders/lib/cell.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/weight.wgsl"),
        include_str!("../../../shaders/lib/marks/none.wgsl"),
        include_str!("../../../shaders/update.wgsl"),
    ],
};

/// Frame rate for which lambda is stated (spec 1 §3).
pub(super) const NOMINAL_RATE_HZ: f64 = 30.0;

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

/// Declares the grids of a frame and appends the given text of the pass.
pub(super) fn append(plan: &mut Plan, job: &Job, pass: ShaderSource) -> Result<()> {
    plan.uniform::<UpdateParams>("update_params")?;
    for grid in ["evidence", "occupancy", "state"] {
        plan.product(grid, job.grid_bytes(4))?;
    }
    plan.step(pass, Invocations::area(job.side(), job.side()), &[])?;
    plan.with(&[("weighted", job.weighted()), ("gated", job.gated())])
}

/// The parameters of a frame with that share of the old occupancy kept.
pub fn params(job: &Job, [origin_slot_x, origin_slot_y]: [u32; 2], lambda: f64) -> UpdateParams {
    let config = &job.config;
    let temporal = config.method == Method::Temporal;
    UpdateParams {
        side: job.side(),
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
pub struct Update;

impl Stage for Update {
    fn append(&self, plan: &mut Plan, job: &Job) -> Result<()> {
        append(plan, job, UPDATE)
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let (job, config) = (moment.job, &moment.job.config);
        let lambda = match moment.since_last_s {
            Some(dt_s) if config.rate_independent => config.lambda.powf(dt_s * NOMINAL_RATE_HZ),
            _ => config.lambda,
        };
        input.set("update_params", &params(job, moment.window.origin_slot(job.side()), lambda))
    }
}
