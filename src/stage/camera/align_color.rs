//! Colour whose images lie on the depth grid in every frame: unpacked, not projected (spec 1 §1).

use std::borrow::Cow;
use std::sync::Arc;

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::sensor::CameraModel;
use crate::stage::camera::color::usable_color;
use crate::stage::camera::ingest::aligned_for_upload;
use crate::stage::{CameraJob, Moment, Stage};

/// The pass.
pub const ALIGN_COLOR: ShaderSource =
    ShaderSource { name: "align_color", parts: &[include_str!("../../../shaders/align_color.wgsl")] };

crate::params! {
    /// Parameters of `align_color`.
    pub struct AlignColorParams {
        /// Words of four pixels.
        pub words: u32,
        /// 0: this frame has no colour.
        pub present: u32,
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
    }
}

/// The stage, for colour images of one calibration.
#[derive(Debug)]
pub struct AlignColor {
    /// What it is built for.
    pub job: Arc<CameraJob>,
    /// The colour camera.
    pub camera: CameraModel,
}

impl Stage for AlignColor {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let job = &*self.job;
        plan.uniform::<AlignColorParams>("align_color_params")?;
        plan.upload("color_raw", u64::from(job.pixel_words()) * 12)?;
        plan.product("color", job.image_bytes(4))?;
        plan.step(ALIGN_COLOR, Invocations::line(job.pixel_words()), &[])
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let color = usable_color(&self.job, moment.frame()?).ok();
        let (words, present) = (self.job.pixel_words(), u32::from(color.is_some()));
        input.set("align_color_params", &AlignColorParams { words, present, pad0: 0, pad1: 0 })?;
        match color {
            Some(color) => input.write("color_raw", &aligned_for_upload(Cow::Borrowed(&color.rgb))),
            None => Ok(()),
        }
    }
}
