//! Depths that end at known panes (spec 4 §1): what a camera sees beyond glass may be mirrored.

use std::sync::Arc;

use glam::{Vec2, Vec4};

use crate::base::{Result, Rigid};
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::sensor::{CameraModel, Distortion};
use crate::stage::camera::see_through::pinhole;
use crate::stage::glass::pane_cells::{PANES_EACH, declare_map_panes};
use crate::stage::{CameraJob, Moment, Stage, rows};

/// The pass.
pub const PANE_CLIP: ShaderSource = ShaderSource {
    name: "pane_clip",
    parts: &[
        include_str!("../../../shaders/lib/glass/pane.wgsl"),
        include_str!("../../../shaders/pane_clip.wgsl"),
    ],
};

crate::params! {
    /// Parameters of `pane_clip`.
    pub struct PaneClipParams {
        /// First row of local from camera, in the map's axes from the origin of `map_panes`.
        pub local_from_camera_x: Vec4,
        /// Second row.
        pub local_from_camera_y: Vec4,
        /// Third row.
        pub local_from_camera_z: Vec4,
        /// Focal lengths.
        pub focal_px: Vec2,
        /// Principal point.
        pub centre_px: Vec2,
        /// Pixels of a row.
        pub width: u32,
        /// Pixels.
        pub pixels: u32,
        /// Panes in `map_panes`, empty ones too.
        pub panes: u32,
        /// Unused.
        pub pad: u32,
    }
}

/// The parameters of one frame: the camera at `local_from_camera` in the map's axes from the origin of `map_panes`, which holds
/// the panes of `lidars` lidars.
pub fn params(camera: &CameraModel, local_from_camera: Rigid, lidars: u32) -> PaneClipParams {
    let [local_from_camera_x, local_from_camera_y, local_from_camera_z] = rows(local_from_camera);
    let [focal_px, centre_px] = pinhole(camera);
    PaneClipParams {
        local_from_camera_x,
        local_from_camera_y,
        local_from_camera_z,
        focal_px,
        centre_px,
        width: camera.width,
        pixels: camera.width * camera.height,
        panes: lidars * PANES_EACH,
        pad: 0,
    }
}

/// Declares `map_panes` and `depth_clipped_m`, and appends the pass over the depths in the buffer `depth`, and `rays`; `lidars`:
/// how many search for glass.
///
/// # Errors
/// From the plan.
pub fn declare(plan: &mut Plan, job: &CameraJob, depth: &str, lidars: u32) -> Result<()> {
    declare_map_panes(plan, lidars)?;
    plan.uniform::<PaneClipParams>("pane_clip_params")?;
    plan.scratch("depth_clipped_m", job.image_bytes(4))?;
    plan.step(PANE_CLIP, Invocations::line(job.pixels()), &[("depth_m", depth)])?;
    plan.with(&[("distorted", job.depth.distortion != Distortion::None)])
}

/// The stage.
#[derive(Debug)]
pub struct PaneClip {
    /// What it is built for.
    pub job: Arc<CameraJob>,
}

impl Stage for PaneClip {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        declare(plan, &self.job, self.job.depth_buffer(), self.job.map.glass_lidars)
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let local_from_camera = moment.local_from_sensor();
        let params = params(&self.job.depth, local_from_camera, self.job.map.glass_lidars);
        input.set("pane_clip_params", &params)
    }
}
