//! Map reliability (spec 1 §9): a small network says which cells are obstacles, by what cameras saw of them and around them.

use std::sync::Arc;

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::stage::perceptron::{Layout, Perceptron, words};
use crate::stage::{CameraJob, Moment, Stage, single};

/// The pass.
pub const MAP_RELIABILITY: ShaderSource = ShaderSource {
    name: "map_reliability",
    parts: &[
        include_str!("../../../shaders/lib/cell.wgsl"),
        include_str!("../../../shaders/lib/evidence.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/weight.wgsl"),
        include_str!("../../../shaders/lib/record.wgsl"),
        include_str!("../../../shaders/lib/fusion/strength.wgsl"),
        include_str!("../../../shaders/map_reliability.wgsl"),
    ],
};

/// The weight file that limpid comes with.
pub const SHIPPED: &[u8] = include_bytes!("../../../weights/map-reliability.safetensors");

/// Names of a cell's inputs, in the order of the shader. Shares are of its looks, the newest counting most; `for` and `against`:
/// logarithms of the evidence; `near`: of the eight cells around it; `wide`: of the 48; `behind`: along the ray.
pub const INPUTS: [&str; 22] = [
    "hit",
    "through",
    "strength",
    "reliability",
    "floor",
    "for",
    "against",
    "looks",
    "distance",
    "lowest",
    "highest",
    "near_for",
    "near_against",
    "near_strong",
    "near_most",
    "wide_for",
    "wide_against",
    "wide_strong",
    "behind_for",
    "far_behind_for",
    "before_for",
    "behind_against",
];

/// Hidden units (`HIDDEN` of the shader).
pub const HIDDEN: usize = 16;

/// Sides of cells that the network knows, metres.
const SIDES_M: std::ops::RangeInclusive<f64> = 0.04..=0.06;

/// Whether the network knows cells of that side, metres.
pub(crate) fn knows_cells_of(side_m: f64) -> bool {
    SIDES_M.contains(&side_m)
}

/// A checked weight file: a cell is an obstacle where the hidden units, each tanh of a weighted sum of inputs, come to at least 0
/// when weighted and added to the bias.
#[derive(Debug, Clone, PartialEq)]
pub struct MapReliability {
    /// Of each hidden unit a weight for each of [`INPUTS`] and what is added.
    pub inner: Vec<f32>,
    /// Of each hidden unit.
    pub outer: Vec<f32>,
    /// What is added at the end; the threshold is in it.
    pub bias: f32,
    /// How far under 0 the sum must come before an obstacle is given up.
    pub release: f32,
}

impl MapReliability {
    /// The weights that limpid comes with.
    ///
    /// # Errors
    /// None; a test reads them.
    pub fn shipped() -> Result<Self> {
        Self::from_bytes(SHIPPED)
    }

    /// Reads a safetensors file from memory: metadata `format`, `inputs` (names, comma-separated) and `release`; F32 tensors
    /// `inner` (16 x 23), `outer` (16) and `bias` (1).
    ///
    /// # Errors
    /// [`crate::Error::Weights`] that names the metadata key or the tensor: a file of another kind or for other inputs, wrong
    /// shapes, numbers that are not finite, a release below 0.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let layout = Layout { format: "map-reliability", inputs: &INPUTS, hidden: HIDDEN, biases: 1 };
        let file = Perceptron::from_bytes(bytes, &layout)?;
        let release = file.number("release", 0.0..=100.0)?;
        Ok(Self { inner: file.inner, outer: file.outer, bias: file.bias[0], release })
    }

    /// As the pass takes it, with `bias` on top of its own.
    pub fn words(&self, bias: f64) -> Vec<u8> {
        words(&self.inner, &self.outer, &[self.bias + single(bias)])
    }
}

crate::params! {
    /// Parameters of `map_reliability`, beside those of evidence.
    pub struct MapReliabilityParams {
        /// Cells along a side.
        pub side: u32,
        /// Slot of window cell (0, 0) along x.
        pub origin_slot_x: u32,
        /// Slot of window cell (0, 0) along y.
        pub origin_slot_y: u32,
        /// Tick of the frame.
        pub tick: u32,
        /// Fixed-point one of weights.
        pub weight_scale: f32,
        /// How far under 0 the network must come before an obstacle is given up.
        pub release: f32,
        /// Unused.
        pub pad_x: u32,
        /// Unused.
        pub pad_y: u32,
    }
}

/// The parameters of a frame.
pub fn params(
    job: &CameraJob,
    network: &MapReliability,
    [origin_slot_x, origin_slot_y]: [u32; 2],
    tick: u32,
) -> MapReliabilityParams {
    MapReliabilityParams {
        side: job.map.side,
        origin_slot_x,
        origin_slot_y,
        tick,
        weight_scale: job.weight_scale(),
        release: network.release,
        pad_x: 0,
        pad_y: 0,
    }
}

/// The stage; `update` runs before it.
#[derive(Debug)]
pub struct JudgeCells {
    /// What it is built for.
    pub job: Arc<CameraJob>,
    /// Its network.
    pub network: Arc<MapReliability>,
}

impl Stage for JudgeCells {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let job = &self.job;
        plan.uniform::<MapReliabilityParams>("map_reliability_params")?;
        plan.fixed("map_reliability_weights", self.network.words(job.config.learned_bias))?;
        let kept = if job.cell_inputs { job.grid_bytes(4 * INPUTS.len() as u64) } else { 16 };
        plan.product("map_reliability_inputs", kept)?;
        plan.step(MAP_RELIABILITY, Invocations::area(job.map.side, job.map.side), &[])?;
        plan.with(&[("weighted", job.weighted()), ("timed", job.counts_by_time())])?;
        plan.with(&[("keep_inputs", job.cell_inputs)])
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let origin_slot = moment.window.origin_slot(self.job.map.side);
        input.set("map_reliability_params", &params(&self.job, &self.network, origin_slot, moment.tick))
    }
}
