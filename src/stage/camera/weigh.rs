//! Reliability from the sensor's own confidence (spec 1 §3). Without one, ingest's weight 1 stays.

use std::sync::Arc;

use std::borrow::Cow;

use bytemuck::cast_slice;

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::stage::camera::ingest::aligned_for_upload;
use crate::stage::{CameraJob, Moment, Stage};

/// The pass.
pub const WEIGH: ShaderSource = ShaderSource {
    name: "weigh",
    parts: &[include_str!("../../../shaders/lib/numbers.wgsl"), include_str!("../../../shaders/weigh.wgsl")],
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
pub struct Weigh {
    /// What it is built for.
    pub job: Arc<CameraJob>,
}

impl Stage for Weigh {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let job = &*self.job;
        plan.uniform::<WeighParams>("weigh_params")?;
        plan.upload("confidence_raw", job.image_bytes(4))?;
        plan.step(WEIGH, Invocations::line(job.pixel_words()), &[])
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        input.set("weigh_params", &WeighParams { words: self.job.pixel_words() })?;
        match &moment.frame()?.confidence {
            Some(confidence) => input.write(
                "confidence_raw",
                &aligned_for_upload(Cow::Borrowed(cast_slice::<f32, u8>(confidence))),
            ),
            // A frame whose confidence did not come is not trusted.
            None => input.clear("confidence_raw"),
        }
    }
}
