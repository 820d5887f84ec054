//! 5x5 median of valid depths (spec 1 §4).

use std::sync::Arc;

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::stage::{CameraJob, Moment, Stage};

/// The pass.
pub const SPATIAL_MEDIAN: ShaderSource =
    ShaderSource { name: "spatial_median", parts: &[include_str!("../../../shaders/spatial_median.wgsl")] };

crate::params! {
    /// Parameters of `spatial_median`.
    pub struct SpatialMedianParams {
        /// Pixels.
        pub width: u32,
        /// Pixels.
        pub height: u32,
    }
}

/// The stage.
#[derive(Debug)]
pub struct SpatialMedian {
    /// What it is built for.
    pub job: Arc<CameraJob>,
}

impl Stage for SpatialMedian {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let job = &*self.job;
        plan.uniform::<SpatialMedianParams>("spatial_median_params")?;
        plan.scratch("depth_median_m", job.image_bytes(4))?;
        plan.step(SPATIAL_MEDIAN, Invocations::area(job.depth.width, job.depth.height), &[])
    }

    fn write(&self, _moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let camera = self.job.depth;
        let params = SpatialMedianParams { width: camera.width, height: camera.height };
        input.set("spatial_median_params", &params)
    }
}
