//! The stages of a camera frame, of a scan and of a published map, one file each: what a stage declares and appends to the
//! plan, and its parameters for one observation. `mapper/stages.rs` lists them in order.

pub mod camera;
pub mod drops;
pub mod glass;
pub mod ground;
mod job;
pub mod lidar;
pub mod map;
mod moment;
pub(crate) mod perceptron;
pub mod targets;

use std::sync::Arc;

use glam::Vec4;

pub(crate) use job::SensorJob;
pub use job::{CameraJob, LidarJob, MapJob};
pub use moment::Moment;

pub(crate) use crate::base::single;
use crate::base::{Refused, Result, Rigid};
use crate::gpu::{FrameInput, Plan};
use crate::sensor::Observation;

/// A stage of a method; it holds its own settings.
pub trait Stage: std::fmt::Debug + Send + Sync {
    /// Declares its buffers and appends its passes.
    ///
    /// # Errors
    /// From the plan: a name taken, a buffer missing, a shader that does not parse.
    fn append(&self, plan: &mut Plan) -> Result<()>;

    /// Whether it can take an observation; asked before anything is written.
    ///
    /// # Errors
    /// Why not.
    fn check(&self, _observation: &Observation) -> std::result::Result<(), Refused> {
        Ok(())
    }

    /// Writes its parameters and data for one observation.
    ///
    /// # Errors
    /// [`crate::Error::Plan`] where data do not fit their buffer.
    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()>;
}

/// What brings colour onto the depth grid, where colour is wanted and there is some.
pub(crate) fn color_stage(job: &Arc<CameraJob>) -> Option<Box<dyn Stage>> {
    job.color.map(|camera| -> Box<dyn Stage> {
        match job.color_aligned {
            true => Box::new(camera::align_color::AlignColor { job: Arc::clone(job), camera }),
            false => Box::new(camera::register_color::RegisterColor { job: Arc::clone(job), camera }),
        }
    })
}

/// The rows of a transform as shaders take them: rotation in x, y, z, translation in w.
pub fn rows(transform: Rigid) -> [Vec4; 3] {
    let rotation = transform.rotation_matrix().transpose();
    let translation = transform.translation_m.to_array();
    let row = |axis: usize| rotation.col(axis).extend(translation[axis]).as_vec4();
    [row(0), row(1), row(2)]
}
