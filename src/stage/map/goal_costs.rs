//! Costs of the map by the goal-adaptive law (spec 2 §4, spec 4 §2).

use std::sync::Arc;

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::stage::{MapJob, Moment, Stage};

/// The pass.
pub const GOAL_COSTS: ShaderSource = ShaderSource {
    name: "goal_costs",
    parts: &[
        include_str!("../../../shaders/lib/scan.wgsl"),
        include_str!("../../../shaders/lib/verdict.wgsl"),
        include_str!("../../../shaders/lib/classes/kept.wgsl"),
        include_str!("../../../shaders/goal_costs.wgsl"),
    ],
};

crate::params! {
    /// Parameters of `goal_costs`.
    pub struct GoalCostsParams {
        /// Cells along a side.
        pub side: u32,
        /// Words of four cells a row.
        pub quads: u32,
    }
}

/// The parameters for a window of `side` x `side` cells.
pub fn params(side: u32) -> GoalCostsParams {
    GoalCostsParams { side, quads: side.div_ceil(4) }
}

/// Declares `costmap` and `cell_classes`, four cells a word, and appends the pass over `verdicts` and `inflation`.
///
/// # Errors
/// From the plan.
pub fn declare(plan: &mut Plan, side: u32) -> Result<()> {
    let quads = side.div_ceil(4);
    plan.uniform::<GoalCostsParams>("goal_costs_params")?;
    for grid in ["costmap", "cell_classes"] {
        plan.product(grid, u64::from(side * quads) * 4)?;
    }
    plan.step(GOAL_COSTS, Invocations::area(quads, side), &[])
}

/// The stage.
#[derive(Debug)]
pub struct GoalCosts {
    /// What it is built for.
    pub map: Arc<MapJob>,
}

impl Stage for GoalCosts {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        declare(plan, self.map.side)
    }

    fn write(&self, _moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        input.set("goal_costs_params", &params(self.map.side))
    }
}
