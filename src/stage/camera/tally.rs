//! Counters of a frame (spec 1 §5).

use std::sync::Arc;

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::stage::{CameraJob, Moment, Stage};

/// The pass.
pub const TALLY: ShaderSource = ShaderSource {
    name: "tally",
    parts: &[
        include_str!("../../../shaders/lib/cell.wgsl"),
        include_str!("../../../shaders/lib/counters.wgsl"),
        include_str!("../../../shaders/tally.wgsl"),
    ],
};

/// Enough to fill a GPU a little, few enough to keep atomics rare.
const INVOCATIONS: u32 = 1024;

crate::params! {
    /// Parameters of `tally`.
    pub struct TallyParams {
        /// Words of `strip_counts`.
        pub strips: u32,
        /// Cells of the map.
        pub cells: u32,
        /// Invocations that share the work.
        pub invocations: u32,
        /// Unused.
        pub pad: u32,
    }
}

/// The stage.
#[derive(Debug)]
pub struct Tally {
    /// What it is built for.
    pub job: Arc<CameraJob>,
}

impl Stage for Tally {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        plan.uniform::<TallyParams>("tally_params")?;
        plan.read_back("counters")?;
        plan.step(TALLY, Invocations::line(INVOCATIONS), &[])
    }

    fn write(&self, _moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let job = &self.job;
        let params = TallyParams {
            strips: job.strips(),
            cells: job.map.side * job.map.side,
            invocations: INVOCATIONS,
            pad: 0,
        };
        input.set("tally_params", &params)
    }
}
