//! Gaps between cells that cameras call occupied are lethal too (spec 1 §9, step 7): far away, pixels lie farther apart than cells.

use std::sync::Arc;

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderText};
use crate::map::rule::bridge_wgsl;
use crate::stage::{MapJob, Moment, Stage};

const VERDICT: &str = include_str!("../../../shaders/lib/verdict.wgsl");

/// Occupied cells to bits.
pub fn occupied_shader() -> ShaderText {
    let text = [&bridge_wgsl(), VERDICT, include_str!("../../../shaders/bridge/occupied.wgsl")].join("\n");
    ShaderText { label: "bridge/occupied".into(), entry_point: "occupied", text }
}

/// Bits to verdicts.
pub fn gaps_shader() -> ShaderText {
    let text = [&bridge_wgsl(), VERDICT, include_str!("../../../shaders/bridge/gaps.wgsl")].join("\n");
    ShaderText { label: "bridge/gaps".into(), entry_point: "gaps", text }
}

crate::params! {
    /// Parameters of `bridge/occupied`.
    pub struct BridgeOccupiedParams {
        /// Cells along a side.
        pub side: u32,
        /// 32-bit words a row.
        pub words: u32,
    }
}

crate::params! {
    /// Parameters of `bridge/gaps`.
    pub struct BridgeGapsParams {
        /// Cells along a side.
        pub side: u32,
        /// 32-bit words a row.
        pub words: u32,
    }
}

/// The parameters of both passes for a window of `side` x `side` cells.
pub fn params(side: u32) -> (BridgeOccupiedParams, BridgeGapsParams) {
    let words = side.div_ceil(32);
    (BridgeOccupiedParams { side, words }, BridgeGapsParams { side, words })
}

/// Appends the passes over `verdicts`.
///
/// # Errors
/// From the plan.
pub fn declare(plan: &mut Plan, side: u32) -> Result<()> {
    let words = side * side.div_ceil(32);
    plan.uniform::<BridgeOccupiedParams>("bridge_occupied_params")?;
    plan.uniform::<BridgeGapsParams>("bridge_gaps_params")?;
    plan.scratch("camera_bits", u64::from(words) * 4)?;
    plan.step(occupied_shader(), Invocations::line(words), &[])?;
    plan.step(gaps_shader(), Invocations::line(words), &[])
}

/// The stage.
#[derive(Debug)]
pub struct Bridge {
    /// What it is built for.
    pub map: Arc<MapJob>,
}

impl Stage for Bridge {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        declare(plan, self.map.side)
    }

    fn write(&self, _moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let (occupied, gaps) = params(self.map.side);
        input.set("bridge_occupied_params", &occupied)?;
        input.set("bridge_gaps_params", &gaps)
    }
}
