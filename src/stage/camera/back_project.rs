//! Depth pixels into the cells they end in (spec 1 §3).

use std::sync::Arc;

use bytemuck::cast_slice;
use glam::{Vec2, Vec4};

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::sensor::{CameraModel, Distortion};
use crate::stage::camera::see_through::{TILE, pinhole};
use crate::stage::{CameraJob, Moment, Stage, rows, single};

/// The pass.
pub const BACK_PROJECT: ShaderSource = ShaderSource {
    name: "back_project",
    parts: &[
        include_str!("../../../shaders/lib/cell.wgsl"),
        include_str!("../../../shaders/lib/counters.wgsl"),
        include_str!("../../../shaders/lib/far/kept.wgsl"),
        include_str!("../../../shaders/lib/tile.wgsl"),
        include_str!("../../../shaders/lib/weight.wgsl"),
        include_str!("../../../shaders/back_project.wgsl"),
    ],
};

/// The pass where looks through are counted (spec 1 §9), which asks for no farthest depths.
pub const BACK_PROJECT_ALONE: ShaderSource = ShaderSource {
    name: "back_project",
    parts: &[
        include_str!("../../../shaders/lib/cell.wgsl"),
        include_str!("../../../shaders/lib/counters.wgsl"),
        include_str!("../../../shaders/lib/far/none.wgsl"),
        include_str!("../../../shaders/lib/tile.wgsl"),
        include_str!("../../../shaders/lib/weight.wgsl"),
        include_str!("../../../shaders/back_project.wgsl"),
    ],
};

/// Rows of pixels that one invocation walks down, as in the shader.
pub const STRIP: u32 = 2 * TILE;

/// Columns of pixels that a workgroup takes, as in the shader.
const GROUP: u32 = 64;

/// Rays outside the lens model's field are stored this large, as in the shader.
const NO_RAY: f32 = 1.0e6;

crate::params! {
    /// Parameters of `back_project`.
    pub struct BackProjectParams {
        /// First row of window from camera.
        pub window_from_camera_x: Vec4,
        /// Second row.
        pub window_from_camera_y: Vec4,
        /// Third row; z = 0 is the stated ground.
        pub window_from_camera_z: Vec4,
        /// Pixels.
        pub width: u32,
        /// Pixels.
        pub height: u32,
        /// Cells along a side.
        pub side: u32,
        /// Side of a cell.
        pub resolution_m: f32,
        /// Largest horizontal distance of a mark.
        pub mark_range_m: f32,
        /// Lower edge of the height band.
        pub height_min_m: f32,
        /// Upper edge of the height band.
        pub height_max_m: f32,
        /// Weights up to this count for nothing.
        pub tau: f32,
        /// Fixed-point one of weights.
        pub weight_scale: f32,
        /// Unused.
        pub pad: u32,
        /// Focal lengths.
        pub focal_px: Vec2,
        /// Principal point.
        pub centre_px: Vec2,
        /// Workgroups.
        pub groups: u32,
        /// Workgroups in a column of them.
        pub groups_y: u32,
    }
}

/// Workgroups across and down.
fn groups(camera: &CameraModel) -> [u32; 2] {
    [camera.width.div_ceil(GROUP), camera.height.div_ceil(STRIP)]
}

/// The rays (x/z, y/z) of all pixels, row-major, two f32 each.
pub fn rays(camera: &CameraModel) -> Vec<u8> {
    let ray = |u: u32, v: u32| {
        camera.ray(f64::from(u), f64::from(v)).map_or([NO_RAY; 2], |[x, y]| [single(x), single(y)])
    };
    let all: Vec<[f32; 2]> = (0..camera.height)
        .flat_map(|v| (0..camera.width).map(move |u| (u, v)))
        .map(|(u, v)| ray(u, v))
        .collect();
    cast_slice(&all).to_vec()
}

/// Declares what the pass leaves for those after it, and appends it over the depths in the buffer `depth`; `lowest`: whether
/// the lowest hit of each cell is kept.
///
/// # Errors
/// From the plan.
pub fn declare(plan: &mut Plan, job: &CameraJob, depth: &str, lowest: bool) -> Result<()> {
    plan.uniform::<BackProjectParams>("back_project_params")?;
    plan.scratch("strip_counts", u64::from(job.strips()) * 4)?;
    let pass = if job.counts_trust() {
        BACK_PROJECT_ALONE
    } else {
        let tiles_y = u64::from(job.depth.height.div_ceil(TILE));
        plan.scratch("strip_far_m", u64::from(job.depth.width) * tiles_y * 4)?;
        BACK_PROJECT
    };
    let [groups_x, groups_y] = groups(&job.depth);
    plan.step(pass, Invocations::line(groups_x * groups_y * GROUP), &[("depth_m", depth)])?;
    plan.with(&[
        ("distorted", job.depth.distortion != Distortion::None),
        ("weighted", job.weighted()),
        ("gated", job.gated()),
        ("lowest", lowest),
    ])
}

/// The stage.
#[derive(Debug)]
pub struct BackProject {
    /// What it is built for.
    pub job: Arc<CameraJob>,
}

impl Stage for BackProject {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        declare(plan, &self.job, self.job.clipped_depth(), self.job.keeps_lowest())
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let (job, config) = (&self.job, &self.job.config);
        let window_from_camera = moment.in_window(moment.pose.map_from_sensor(), config.ground_z_m);
        let [x, y, z] = rows(window_from_camera);
        let [groups_x, groups_y] = groups(&job.depth);
        let [focal_px, centre_px] = pinhole(&job.depth);
        let params = BackProjectParams {
            window_from_camera_x: x,
            window_from_camera_y: y,
            window_from_camera_z: z,
            width: job.depth.width,
            height: job.depth.height,
            side: job.map.side,
            resolution_m: single(config.resolution_m),
            mark_range_m: single(config.mark_range_m),
            height_min_m: single(config.height_min_m),
            height_max_m: single(config.height_max_m),
            tau: single(config.tau),
            weight_scale: job.weight_scale(),
            pad: 0,
            focal_px,
            centre_px,
            groups: groups_x * groups_y,
            groups_y,
        };
        input.set("back_project_params", &params)
    }
}
