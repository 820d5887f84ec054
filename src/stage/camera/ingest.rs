//! Raw depth to metres; range gating; weight 1 where there is depth (spec 1 §4).

use std::sync::Arc;

use std::borrow::Cow;

use bytemuck::cast_slice;

use crate::base::Result;
use crate::config::{Config, Method};
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::sensor::DepthSamples;
use crate::stage::{CameraJob, Moment, Stage, single};

/// The pass.
pub const INGEST: ShaderSource = ShaderSource {
    name: "ingest",
    parts: &[include_str!("../../../shaders/lib/numbers.wgsl"), include_str!("../../../shaders/ingest.wgsl")],
};

crate::params! {
    /// Parameters of `ingest`.
    pub struct IngestParams {
        /// vec4 words of raw data.
        pub words: u32,
        /// Metres per count.
        pub unit_m: f32,
        /// Smallest count taken as measured.
        pub raw_min: u32,
        /// Largest count taken as measured.
        pub raw_max: u32,
        /// Smallest depth taken as measured.
        pub depth_min_m: f32,
        /// Largest depth taken as measured.
        pub depth_max_m: f32,
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
    }
}

/// Depths that a method takes as measured: naive, median and temporal take any above 0.
pub fn depth_range_m(config: &Config) -> (f64, f64) {
    match config.method {
        Method::Naive | Method::Median | Method::Temporal => (0.0, f64::from(f32::MAX)),
        Method::Drm => (config.depth_min_m, config.depth_max_m),
        // Auto is resolved before a pipeline is built.
        Method::Range | Method::Auto => (config.depth_min_m, config.range_gate_m.min(config.depth_max_m)),
    }
}

/// 65535 means "no depth" to several drivers, so it is never taken as measured.
const RAW_MAX: f64 = 65534.0;

impl IngestParams {
    /// For `config` and samples of `unit_m` metres a count (counts are compared as integers, so that
    /// a limit that lies on a count takes it in).
    pub fn new(config: &Config, words: u32, unit_m: Option<f64>) -> Self {
        let (min_m, max_m) = depth_range_m(config);
        let unit = unit_m.unwrap_or(1.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 16 bits")]
        let count = |counts: f64| counts.clamp(1.0, RAW_MAX) as u32;
        let beyond = |m: f64| m / unit > RAW_MAX + 1.0;
        Self {
            words,
            unit_m: single(unit),
            raw_min: if beyond(min_m) { 65535 } else { count((min_m / unit - 1e-6).ceil()) },
            raw_max: if max_m < unit { 0 } else { count((max_m / unit + 1e-6).floor()) },
            depth_min_m: single(min_m),
            depth_max_m: single(max_m),
            pad0: 0,
            pad1: 0,
        }
    }
}

/// The stage.
#[derive(Debug)]
pub struct Ingest {
    /// What it is built for.
    pub job: Arc<CameraJob>,
}

/// vec4 words of raw samples: eight counts or four floats each.
fn words(job: &CameraJob) -> u32 {
    job.pixels().div_ceil(if job.float_depth { 4 } else { 8 })
}

impl Stage for Ingest {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let job = &*self.job;
        let words = words(job);
        plan.uniform::<IngestParams>("ingest_params")?;
        plan.upload("depth_raw", u64::from(words) * 16)?;
        let pixels_per_word = if job.float_depth { 4 } else { 8 };
        plan.scratch("depth_m", u64::from(words) * pixels_per_word * 4)?;
        plan.product("reliability", u64::from(words) * pixels_per_word * 4)?;
        plan.step(INGEST, Invocations::line(words), &[])?;
        plan.with(&[("floats", job.float_depth)])
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let (bytes, unit_m) = match &moment.frame()?.depth.samples {
            DepthSamples::Integer { raw, unit_m } => {
                (Cow::Borrowed(cast_slice::<u16, u8>(raw)), Some(*unit_m))
            }
            DepthSamples::Metres(samples) => (Cow::Borrowed(cast_slice::<f32, u8>(samples)), None),
        };
        let params = IngestParams::new(&self.job.config, words(&self.job), unit_m);
        input.set("ingest_params", &params)?;
        input.write("depth_raw", &aligned_for_upload(bytes))
    }
}

/// Mapped memory takes whole words of four bytes.
pub(crate) fn aligned_for_upload(bytes: Cow<'_, [u8]>) -> Cow<'_, [u8]> {
    if bytes.len().is_multiple_of(4) {
        return bytes;
    }
    let mut padded = bytes.into_owned();
    padded.resize(padded.len().next_multiple_of(4), 0);
    Cow::Owned(padded)
}
