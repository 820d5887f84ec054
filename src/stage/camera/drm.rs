//! Reliability by DRM-Net (spec 1 §1): resize, the network's blocks, back to the native size.

use std::sync::Arc;

use crate::base::{Refused, Result};
use crate::config::{Config, Method};
use crate::gpu::{FrameInput, Invocations, Plan, ShaderText};
use crate::network::weights::{NATIVE_SIZE, Network};
use crate::network::{Backend, INPUT, Kernel, OUTPUT, Passes};
use crate::sensor::Observation;
use crate::stage::camera::color::usable_color;
use crate::stage::camera::ingest::depth_range_m;
use crate::stage::{CameraJob, Moment, Stage, single};

crate::params! {
    /// Parameters of `resize`.
    pub struct ResizeParams {
        /// 1 / metres that depth is divided by before it goes into the network.
        pub per_metre: f32,
        /// The same for its change since the frame before; 0 where none came right before.
        pub change_per_metre: f32,
        /// Unused.
        pub pad1: u32,
        /// Unused.
        pub pad2: u32,
    }
}

/// Frames farther apart than this do not follow each other: the network is trained on the change of depth between frames of a
/// running camera, and on no change at all for a recording's first frame (`FIRST_FRAMES` of `weights/train.py`).
pub const MOST_GAP_S: f64 = 0.2;

impl ResizeParams {
    /// For depth that is divided by `scale_m`, of a frame `since_last_s` after the one that depth is compared with, where it
    /// follows one.
    ///
    /// The first frame, and one after a gap or a jump back in time, changes by 0, as the first of a recording in training: a
    /// change over a longer time is larger than any that the network has learned from.
    pub fn new(scale_m: f64, since_last_s: Option<f64>) -> Self {
        let follows = since_last_s.is_some_and(|gap_s| gap_s > 0.0 && gap_s <= MOST_GAP_S);
        let per_metre = single(1.0 / scale_m);
        Self { per_metre, change_per_metre: if follows { per_metre } else { 0.0 }, pad1: 0, pad2: 0 }
    }
}

crate::params! {
    /// Parameters of `restore`.
    pub struct RestoreParams {
        /// 1: the frame has no usable colour, and depth counts by its range alone.
        pub alone: u32,
        /// Smallest depth of that range.
        pub nearest_m: f32,
        /// Largest depth of that range.
        pub farthest_m: f32,
        /// Unused.
        pub pad: u32,
    }
}

/// A depth that lies on a limit may be rounded up on its way to the shader.
const ROUNDING: f64 = 1.0 + 1e-6;

impl RestoreParams {
    /// `alone`: the frame has no usable colour, so that its depth counts as method range has it.
    pub fn new(config: &Config, alone: bool) -> Self {
        let (nearest_m, farthest_m) = depth_range_m(&Config { method: Method::Range, ..config.clone() });
        Self {
            alone: u32::from(alone),
            nearest_m: single(nearest_m / ROUNDING),
            farthest_m: single(farthest_m * ROUNDING),
            pad: 0,
        }
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
    /// What it is built for.
    pub job: Arc<CameraJob>,
    /// What it runs.
    pub drm: Drm,
}

/// Native pixels, along one axis, that one of the network's pixels may touch.
pub(crate) fn span(native: u32, size: u32) -> u32 {
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
}

/// From depth and colour of `native` rows and columns to a tensor of `size` rows and columns: the pass and its invocations.
pub fn resize(native: [u32; 2], size: [u32; 2], backend: Backend) -> (ShaderText, Invocations) {
    let spans = [("SPAN_X", span(native[1], size[1])), ("SPAN_Y", span(native[0], size[0]))];
    let constants: Vec<_> = sizes(native, size).into_iter().chain(spans).collect();
    let text = Kernel::Resize.text("net/resize".into(), backend, &constants);
    (text, Invocations::line(size[0] * size[1]))
}

/// From reliability of `size` rows and columns to `native` ones: the pass and its invocations.
pub fn restore(native: [u32; 2], size: [u32; 2], backend: Backend) -> (ShaderText, Invocations) {
    let words = native[1].div_ceil(4);
    let more = [("WORDS", words), ("COLUMNS", columns(native[1], size[1]))];
    let constants: Vec<_> = sizes(native, size).into_iter().chain(more).collect();
    let text = Kernel::Restore.text("net/restore".into(), backend, &constants);
    (text, Invocations::line(words * native[0]))
}

fn sizes(native: [u32; 2], size: [u32; 2]) -> [(&'static str, u32); 4] {
    [("WIDTH", size[1]), ("HEIGHT", size[0]), ("NATIVE_WIDTH", native[1]), ("NATIVE_HEIGHT", native[0])]
}

impl Stage for DrmNet {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let job = &*self.job;
        let Drm { network, backend } = &self.drm;
        let passes = Passes { network, size: Self::size(), backend: *backend, keep_all: false };
        passes.check_size()?;
        passes.declare_input(plan)?;
        let native = [job.depth.height, job.depth.width];
        let [rows, columns] = Self::size();
        plan.uniform::<ResizeParams>("resize_params")?;
        plan.state("depth_before", u64::from(rows) * u64::from(columns) * 4)?;
        let (resize, invocations) = resize(native, Self::size(), *backend);
        plan.step(resize, invocations, &[("sink", INPUT)])?;
        passes.append(plan)?;
        plan.uniform::<RestoreParams>("restore_params")?;
        let (restore, invocations) = restore(native, Self::size(), *backend);
        plan.step(restore, invocations, &[("reliability_low", OUTPUT)])
    }

    fn check(&self, observation: &Observation) -> std::result::Result<(), Refused> {
        let Some(frame) = observation.frame().filter(|_| !self.job.depth_alone) else { return Ok(()) };
        // Black in place of colour would be a scene of its own to the network.
        usable_color(&self.job, frame).map(drop).map_err(|reason| {
            let reason = format!("cannot be used, and method drm needs it: {reason}");
            Refused::Image { what: "colour", reason }
        })
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let since_last_s = moment.since_last_s.filter(|_| moment.follows);
        input.set("resize_params", &ResizeParams::new(self.drm.network.depth_scale_m, since_last_s))?;
        let alone = usable_color(&self.job, moment.frame()?).is_err();
        input.set("restore_params", &RestoreParams::new(&self.job.config, alone))
    }
}
