//! Reliability per pixel: a constant or the sensor's own confidence (spec 1 §3, §4).

use std::borrow::Cow;

use bytemuck::cast_slice;

use crate::error::Result;
use crate::gpu::frame::FrameInput;
use crate::gpu::{Invocations, Plan, ShaderSource};
use crate::stage::ingest::aligned_for_upload;
use crate::stage::{Job, Moment, Stage};

/// Weight 1 wherever there is depth.
pub const CONSTANT: ShaderSource =
    ShaderSource { name: "weigh/constant", parts: &[include_str!("../../shaders/weigh/constant.wgsl")] };

/// Weight from a confidence image.
pub const CONFIDENCE: ShaderSource = ShaderSource {
    name: "weigh/confidence",
    parts: &[
        include_str!("../../shaders/lib/numbers.wgsl"),
        include_str!("../../shaders/weigh/confidence.wgsl"),
    ],
};

crate::params! {
    /// Parameters of `weigh`.
    pub struct WeighParams {
        /// vec4 words of pixels.
        pub words: u32,
    }
}

/// The stage.
#[derive(Debug)]
pub struct Weigh;

impl Stage for Weigh {
    fn append(&self, plan: &mut Plan, job: &Job) -> Result<()> {
        plan.uniform::<WeighParams>("weigh_params")?;
        plan.scratch("reliability", job.image_bytes(4))?;
        let depth = job.depth_buffer();
        if job.confidence {
            plan.upload("confidence_raw", job.image_bytes(4))?;
        }
        let pass = if job.confidence { CONFIDENCE } else { CONSTANT };
        plan.step(pass, Invocations::line(job.pixel_words()), &[("depth_m", depth)])
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        input.set("weigh_params", &WeighParams { words: moment.job.pixel_words() })?;
        if !moment.job.confidence {
            return Ok(());
        }
        match &moment.frame.confidence {
            Some(confidence) => input.write(
                "confidence_raw",
                &aligned_for_upload(Cow::Borrowed(cast_slice::<f32, u8>(confidence))),
            ),
            // A frame whose confidence did not come is not trusted.
            None => input.clear("confidence_raw"),
        }
    }
}
