//! The occupancy layer of a map with several sensors (spec 4 §1): when, by whom and how each cell was last seen by a camera,
//! written by `update`.

use crate::base::Result;
use crate::gpu::{Plan, ShaderSource};
use crate::stage::camera::update::{self, NOMINAL_RATE_HZ};
use crate::stage::map::layers::Layers;
use crate::stage::{CameraJob, single};

/// The pass.
pub const UPDATE_MARKS: ShaderSource = ShaderSource {
    name: "update",
    parts: &[
        include_str!("../../../shaders/lib/cell.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/weight.wgsl"),
        include_str!("../../../shaders/lib/record.wgsl"),
        include_str!("../../../shaders/lib/marks/kept.wgsl"),
        include_str!("../../../shaders/update.wgsl"),
    ],
};

/// Length of a tick, seconds.
const TICK_S: f64 = 0.01;

/// Least logarithm of lambda: what it leaves of any occupancy after one tick is 0 in f32.
const LEAST_LOG2: f64 = -1000.0;

crate::params! {
    /// Parameters of the layer, beside those of `update`.
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

/// The parameters of one frame of the sensor of that number, counted from 0, where `lambda` is stated for 30 Hz.
pub fn params(tick: u32, sensor: u32, lambda: f64) -> CellMarksParams {
    let log2_lambda_per_tick = single((lambda.log2() * TICK_S * NOMINAL_RATE_HZ).max(LEAST_LOG2));
    CellMarksParams { tick, sensor: sensor + 1, log2_lambda_per_tick, pad: 0 }
}

/// Declares the layer and the buffers of `update`, and appends the pass. `timed`: the old occupancy counts less the longer ago
/// it is (`rate_independent`, or several cameras); `lowest`: `back_project` keeps the lowest hits.
///
/// # Errors
/// From the plan.
pub fn declare(plan: &mut Plan, job: &CameraJob, timed: bool, lowest: bool) -> Result<()> {
    Layers { cameras: true, ..Layers::default() }.declare(plan, job.map.side)?;
    plan.uniform::<CellMarksParams>("cell_marks_params")?;
    update::append(plan, job, UPDATE_MARKS)?;
    plan.with(&[("timed", timed), ("lowest", lowest)])
}
