//! The rolling window (spec 1 §3): a ring buffer of cells, moved by whole cells.

use std::sync::Arc;

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::stage::{CameraJob, Moment, Stage};

/// The pass.
pub const MOVE_WINDOW: ShaderSource = ShaderSource {
    name: "move_window",
    parts: &[
        include_str!("../../../shaders/lib/cell.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/counters.wgsl"),
        include_str!("../../../shaders/move_window.wgsl"),
    ],
};

/// Counters of a frame, in the order of `shaders/lib/counters.wgsl`.
pub const COUNTERS: u64 = 8;

crate::params! {
    /// Parameters of `move_window`.
    pub struct MoveWindowParams {
        /// Cells along a side.
        pub side: u32,
        /// Slot of window cell (0, 0) along x.
        pub origin_slot_x: u32,
        /// Slot of window cell (0, 0) along y.
        pub origin_slot_y: u32,
        /// Cells moved along x.
        pub shift_x: i32,
        /// Cells moved along y.
        pub shift_y: i32,
        /// 1: every cell starts unknown.
        pub forget: u32,
    }
}

/// The stage.
#[derive(Debug)]
pub struct MoveWindow {
    /// What it is built for.
    pub job: Arc<CameraJob>,
}

impl Stage for MoveWindow {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let job = &*self.job;
        plan.uniform::<MoveWindowParams>("move_window_params")?;
        plan.state("cells", job.grid_bytes(16))?;
        plan.scratch("cell_hits", job.grid_bytes(16))?;
        plan.scratch("seen_through", job.grid_bytes(4))?;
        plan.scratch("counters", COUNTERS * 4)?;
        plan.step(MOVE_WINDOW, Invocations::area(job.side, job.side), &[])
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let side = self.job.side;
        let [origin_slot_x, origin_slot_y] = moment.window.origin_slot(side);
        let [shift_x, shift_y] = moment.window.shift;
        let forget = u32::from(moment.window.forget);
        let params = MoveWindowParams { side, origin_slot_x, origin_slot_y, shift_x, shift_y, forget };
        input.set("move_window_params", &params)
    }
}
