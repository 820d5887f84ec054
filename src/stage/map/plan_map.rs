//! The plan map: costs in Nav2's scale and a class per cell (spec 2 §4). An unknown cell stays unknown unless the
//! inflated cost is 253, as in the camera's map: no beam has shown that it is free.

use std::sync::Arc;

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::stage::lidar::intensity_classes::solid_value;
use crate::stage::{LidarJob, Moment, Stage, single};

/// The pass.
pub const PLAN_MAP: ShaderSource = ShaderSource {
    name: "plan_map",
    parts: &[include_str!("../../../shaders/lib/scan.wgsl"), include_str!("../../../shaders/plan_map.wgsl")],
};

crate::params! {
    /// Parameters of `plan_map`.
    pub struct PlanMapParams {
        /// Cells along a side.
        pub side: u32,
        /// Words of four cells a row.
        pub quads: u32,
        /// Nav2 cost of passable cells.
        pub passable_cost: u32,
        /// Value of a layer that counts fully.
        pub solid_value: f32,
    }
}

/// The stage.
#[derive(Debug)]
pub struct PlanMap {
    /// What it is built for.
    pub job: Arc<LidarJob>,
}

impl Stage for PlanMap {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let job = &*self.job;
        let (side, quads) = (job.side, job.side.div_ceil(4));
        plan.uniform::<PlanMapParams>("plan_map_params")?;
        plan.scratch("plan_costs", u64::from(side * quads) * 4)?;
        plan.scratch("plan_classes", u64::from(side * quads) * 4)?;
        plan.product("cell_values", job.grid_bytes(16))?;
        plan.step(PLAN_MAP, Invocations::area(quads, side), &[])?;
        plan.with(&[("keep_layers", job.layers)])
    }

    fn write(&self, _moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let job = &self.job;
        let params = PlanMapParams {
            side: job.side,
            quads: job.side.div_ceil(4),
            passable_cost: job.config.passable_cost,
            solid_value: single(solid_value(job)),
        };
        input.set("plan_map_params", &params)
    }
}
