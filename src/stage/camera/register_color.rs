//! Colour at the depth camera's pixels (spec 1 §1).

use std::borrow::Cow;
use std::sync::Arc;

use glam::{Vec2, Vec4};

use crate::base::{Result, Rigid};
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::sensor::CameraModel;
use crate::stage::camera::color::usable_color;
use crate::stage::camera::ingest::aligned_for_upload;
use crate::stage::camera::see_through::{lens, pinhole};
use crate::stage::{CameraJob, Moment, Stage, rows};

/// The pass.
pub const REGISTER_COLOR: ShaderSource = ShaderSource {
    name: "register_color",
    parts: &[
        include_str!("../../../shaders/lib/lens.wgsl"),
        include_str!("../../../shaders/register_color.wgsl"),
    ],
};

crate::params! {
    /// Parameters of `register_color`.
    pub struct RegisterColorParams {
        /// First row of colour camera from depth camera.
        pub color_from_depth_x: Vec4,
        /// Second row.
        pub color_from_depth_y: Vec4,
        /// Third row.
        pub color_from_depth_z: Vec4,
        /// Colour lens: k1, k2, p1, p2; of a fisheye lens k1 to k4.
        pub lens_a: Vec4,
        /// k3, k4, k5, k6.
        pub lens_b: Vec4,
        /// Focal lengths of the colour camera.
        pub focal_px: Vec2,
        /// Its principal point.
        pub centre_px: Vec2,
        /// Pixels.
        pub color_width: u32,
        /// Pixels.
        pub color_height: u32,
        /// Pixels of the depth image.
        pub pixels: u32,
        /// 1: colour lies on the depth grid already.
        pub aligned: u32,
        /// 0: this frame has no colour.
        pub present: u32,
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
        /// Unused.
        pub pad2: u32,
    }
}

/// The stage, for colour images of one calibration.
#[derive(Debug)]
pub struct RegisterColor {
    /// What it is built for.
    pub job: Arc<CameraJob>,
    /// The colour camera.
    pub camera: CameraModel,
}

impl Stage for RegisterColor {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let job = &*self.job;
        plan.uniform::<RegisterColorParams>("register_color_params")?;
        plan.upload("color_raw", u64::from(self.camera.width) * u64::from(self.camera.height) * 3)?;
        plan.product("color", job.image_bytes(4))?;
        plan.step(REGISTER_COLOR, Invocations::line(job.pixels()), &[])?;
        plan.with(&[("fisheye", self.camera.distortion.is_fisheye())])
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let job = &self.job;
        let color = usable_color(job, moment.frame()?).ok();
        let camera = color.map_or(self.camera, |c| c.camera);
        let transform = moment.frame()?.color_from_depth.unwrap_or(Rigid::IDENTITY);
        let [x, y, z] = rows(transform);
        let [lens_a, lens_b] = lens(&camera);
        let [focal_px, centre_px] = pinhole(&camera);
        let params = RegisterColorParams {
            color_from_depth_x: x,
            color_from_depth_y: y,
            color_from_depth_z: z,
            lens_a,
            lens_b,
            focal_px,
            centre_px,
            color_width: camera.width,
            color_height: camera.height,
            pixels: job.pixels(),
            aligned: u32::from(moment.frame()?.color_is_aligned()),
            present: u32::from(color.is_some()),
            pad0: 0,
            pad1: 0,
            pad2: 0,
        };
        input.set("register_color_params", &params)?;
        match color {
            Some(color) => input.write("color_raw", &aligned_for_upload(Cow::Borrowed(&color.rgb))),
            None => Ok(()),
        }
    }
}
