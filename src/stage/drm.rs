//! Reliability by DRM-Net (spec 1 §1): resize, the network's blocks, back to the native size.

use std::sync::Arc;

use crate::error::{Error, Result};
use crate::gpu::{FrameInput, Invocations, Plan};
use crate::network::{Backend, INPUT, Kernel, OUTPUT, Passes};
use crate::stage::{Job, Moment, Stage, single};
use crate::weights::{NATIVE_SIZE, Network};

crate::params! {
    /// Parameters of `resize`.
    pub struct ResizeParams {
        /// 1 / metres that depth is divided by before it goes into the network.
        pub per_metre: f32,
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
        /// Unused.
        pub pad2: u32,
    }
}

/// The network of a pipeline.
#[derive(Debug, Clone, PartialEq)]
pub struct Drm {
    /// Layers and weights.
    pub network: Arc<Network>,
    /// How its kernels reach tensors.
    pub backend: Backend,
}

/// The stage.
#[derive(Debug)]
pub struct DrmNet {
    /// What it runs.
    pub drm: Drm,
}

/// Native pixels, along one axis, that one of the network's pixels may touch.
fn span(native: u32, size: u32) -> u32 {
    if native.is_multiple_of(size) {
        native / size
    } else if size.is_multiple_of(native) {
        1
    } else {
        native / size + 2
    }
}

/// Columns of the network that four native pixels in a row draw on.
fn columns(native: u32, size: u32) -> u32 {
    (3 * size).div_ceil(native) + 2
}

impl DrmNet {
    /// Rows and columns of the network's input.
    fn size() -> [u32; 2] {
        NATIVE_SIZE.map(|extent| u32::try_from(extent).unwrap_or(0))
    }

    fn sizes(job: &Job) -> [(&'static str, u32); 4] {
        let [height, width] = Self::size();
        [
            ("WIDTH", width),
            ("HEIGHT", height),
            ("NATIVE_WIDTH", job.depth.width),
            ("NATIVE_HEIGHT", job.depth.height),
        ]
    }

    fn resize(&self, plan: &mut Plan, job: &Job) -> Result<()> {
        let [height, width] = Self::size();
        plan.uniform::<ResizeParams>("resize_params")?;
        plan.state("depth_before", u64::from(width) * u64::from(height) * 4)?;
        let spans = [("SPAN_X", span(job.depth.width, width)), ("SPAN_Y", span(job.depth.height, height))];
        let constants: Vec<_> = Self::sizes(job).into_iter().chain(spans).collect();
        let text = Kernel::Resize.text("net/resize".into(), self.drm.backend, &constants);
        plan.step(text, Invocations::line(width * height), &[("sink", INPUT)])
    }

    fn restore(&self, plan: &mut Plan, job: &Job) -> Result<()> {
        let [_, width] = Self::size();
        let words = job.depth.width.div_ceil(4);
        let more = [("WORDS", words), ("COLUMNS", columns(job.depth.width, width))];
        let constants: Vec<_> = Self::sizes(job).into_iter().chain(more).collect();
        let text = Kernel::Restore.text("net/restore".into(), self.drm.backend, &constants);
        plan.step(text, Invocations::line(words * job.depth.height), &[("reliability_low", OUTPUT)])
    }
}

impl Stage for DrmNet {
    fn append(&self, plan: &mut Plan, job: &Job) -> Result<()> {
        let Drm { network, backend } = &self.drm;
        let passes = Passes { network, size: Self::size(), backend: *backend, keep_all: false };
        passes.check_size()?;
        passes.declare_input(plan)?;
        self.resize(plan, job)?;
        passes.append(plan)?;
        self.restore(plan, job)
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let placed = moment.frame.color.is_some() && moment.frame.color_from_depth.is_some();
        if !placed {
            // Black in place of colour would be a scene of its own to the network.
            let reason = "is missing, or its place relative to depth is; method drm needs it".into();
            return Err(Error::Input { what: "colour image".into(), reason });
        }
        let per_metre = single(1.0 / self.drm.network.depth_scale_m);
        input.set("resize_params", &ResizeParams { per_metre, pad0: 0, pad1: 0, pad2: 0 })
    }
}
