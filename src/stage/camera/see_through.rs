//! Cells that trusted rays cross before they end (spec 1 §3), one gather per cell.

use std::sync::Arc;

use glam::{Vec2, Vec4};

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::sensor::CameraModel;
use crate::stage::camera::view;
use crate::stage::{CameraJob, Moment, Stage, rows, single};

/// Farthest depths in tiles.
pub const TILES: ShaderSource = ShaderSource {
    name: "see_through/tiles",
    parts: &[
        include_str!("../../../shaders/lib/tile.wgsl"),
        include_str!("../../../shaders/see_through/tiles.wgsl"),
    ],
};

/// Farthest depths in and around tiles.
pub const AROUND: ShaderSource = ShaderSource {
    name: "see_through/around",
    parts: &[include_str!("../../../shaders/see_through/around.wgsl")],
};

/// Seen-through cells, for the mean of the weights.
pub const GATHER: ShaderSource = ShaderSource {
    name: "see_through/gather",
    parts: &[
        include_str!("../../../shaders/lib/cell.wgsl"),
        include_str!("../../../shaders/lib/lens.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/tile.wgsl"),
        include_str!("../../../shaders/lib/weight.wgsl"),
        include_str!("../../../shaders/lib/looking/first.wgsl"),
        include_str!("../../../shaders/see_through/gather.wgsl"),
    ],
};

/// Shares of looks through all cells, for evidence that counts trust (spec 1 §9).
pub const GATHER_SHARES: ShaderSource = ShaderSource {
    name: "see_through/gather",
    parts: &[
        include_str!("../../../shaders/lib/cell.wgsl"),
        include_str!("../../../shaders/lib/evidence.wgsl"),
        include_str!("../../../shaders/lib/layers.wgsl"),
        include_str!("../../../shaders/lib/lens.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/weight.wgsl"),
        include_str!("../../../shaders/lib/looking/share.wgsl"),
        include_str!("../../../shaders/see_through/gather.wgsl"),
    ],
};

/// Side of a tile in pixels, as in `shaders/lib/tile.wgsl`.
pub const TILE: u32 = 8;

crate::params! {
    /// Parameters of `see_through/tiles`.
    pub struct SeeThroughTilesParams {
        /// Pixels.
        pub width: u32,
        /// Tiles across.
        pub tiles_x: u32,
        /// Tiles down.
        pub tiles_y: u32,
        /// Unused.
        pub pad: u32,
    }
}

crate::params! {
    /// Parameters of `see_through/around`.
    pub struct SeeThroughAroundParams {
        /// Tiles across.
        pub tiles_x: u32,
        /// Tiles down.
        pub tiles_y: u32,
    }
}

crate::params! {
    /// Parameters of `see_through/gather`.
    pub struct SeeThroughGatherParams {
        /// First row of camera from window.
        pub camera_from_window_x: Vec4,
        /// Second row.
        pub camera_from_window_y: Vec4,
        /// Third row.
        pub camera_from_window_z: Vec4,
        /// k1, k2, p1, p2; of a fisheye lens k1 to k4.
        pub lens_a: Vec4,
        /// k3, k4, k5, k6.
        pub lens_b: Vec4,
        /// Focal lengths.
        pub focal_px: Vec2,
        /// Principal point.
        pub centre_px: Vec2,
        /// Smallest ideal ray of any pixel.
        pub field_min: Vec2,
        /// Largest ideal ray of any pixel.
        pub field_max: Vec2,
        /// Camera in the window.
        pub camera_xy_m: Vec2,
        /// Pixels.
        pub width: u32,
        /// Pixels.
        pub height: u32,
        /// Cells along a side.
        pub side: u32,
        /// Slot of window cell (0, 0) along x.
        pub origin_slot_x: u32,
        /// Slot of window cell (0, 0) along y.
        pub origin_slot_y: u32,
        /// Pixels that make a hit.
        pub min_hits: u32,
        /// Side of a cell.
        pub resolution_m: f32,
        /// Largest horizontal distance of clearing.
        pub mark_range_m: f32,
        /// Lower edge of the height band.
        pub height_min_m: f32,
        /// Upper edge of the height band.
        pub height_max_m: f32,
        /// Weights up to this count for nothing.
        pub tau: f32,
        /// Tiles across.
        pub tiles_x: u32,
        /// First cell of the view along x.
        pub first_x: u32,
        /// First cell of the view along y.
        pub first_y: u32,
    }
}

/// Tiles across and down.
fn tiles(camera: &CameraModel) -> [u32; 2] {
    [camera.width.div_ceil(TILE), camera.height.div_ceil(TILE)]
}

/// Coefficients as shaders take them: (k1, k2, p1, p2) and (k3, k4, k5, k6); of a fisheye lens (k1, k2, k3, k4) and zeros.
pub(crate) fn lens(camera: &CameraModel) -> [Vec4; 2] {
    let [k1, k2, p1, p2, k3, k4, k5, k6] = camera.distortion.coefficients().map(single);
    [Vec4::new(k1, k2, p1, p2), Vec4::new(k3, k4, k5, k6)]
}

/// Focal lengths and principal point as shaders take them.
pub(crate) fn pinhole(camera: &CameraModel) -> [Vec2; 2] {
    let [fx, fy, cx, cy] = [camera.fx, camera.fy, camera.cx, camera.cy].map(single);
    [Vec2::new(fx, fy), Vec2::new(cx, cy)]
}

/// Bounds of the ideal rays through the image's border (the field is widest there): half a pixel out at the
/// sides, but not above or below, where half a pixel would clear a hand's breadth of floor that no ray crosses.
pub fn field(camera: &CameraModel) -> [Vec2; 2] {
    let (right, bottom) = (f64::from(camera.width) - 0.5, f64::from(camera.height - 1));
    let across = (0..=camera.width).map(|u| f64::from(u) - 0.5).flat_map(|u| [(u, 0.0), (u, bottom)]);
    let down = (0..camera.height).map(f64::from).flat_map(|v| [(-0.5, v), (right, v)]);
    let mut bounds = [Vec2::splat(f32::MAX), Vec2::splat(f32::MIN)];
    for [x, y] in across.chain(down).filter_map(|(u, v)| camera.ray_or_edge(u, v)) {
        let ray = Vec2::new(single(x), single(y));
        bounds = [bounds[0].min(ray), bounds[1].max(ray)];
    }
    bounds
}

/// The stage, with the camera's field of view.
#[derive(Debug)]
pub struct SeeThrough {
    job: Arc<CameraJob>,
    field: [Vec2; 2],
}

impl SeeThrough {
    /// For the images of a camera.
    pub fn new(job: &Arc<CameraJob>) -> Self {
        Self { job: Arc::clone(job), field: field(&job.depth) }
    }
}

/// Appends the pass over the depths in the buffer `depth`, and where it ends at the first look through, those before it that tell
/// where none can be.
///
/// # Errors
/// From the plan.
pub fn declare(plan: &mut Plan, job: &CameraJob, depth: &str) -> Result<()> {
    plan.uniform::<SeeThroughGatherParams>("see_through_gather_params")?;
    let gather = if job.counts_trust() {
        GATHER_SHARES
    } else {
        declare_tiles(plan, job)?;
        GATHER
    };
    plan.step(gather, Invocations::area(job.map.side, job.map.side), &[("depth_m", depth)])?;
    plan.with(&[("weighted", job.weighted()), ("fisheye", job.depth.distortion.is_fisheye())])
}

fn declare_tiles(plan: &mut Plan, job: &CameraJob) -> Result<()> {
    let [tiles_x, tiles_y] = tiles(&job.depth);
    plan.uniform::<SeeThroughTilesParams>("see_through_tiles_params")?;
    plan.uniform::<SeeThroughAroundParams>("see_through_around_params")?;
    for tiles in ["tile_far_m", "around_far_m"] {
        plan.scratch(tiles, u64::from(tiles_x) * u64::from(tiles_y) * 4)?;
    }
    plan.step(TILES, Invocations::area(tiles_x, tiles_y), &[])?;
    plan.step(AROUND, Invocations::area(tiles_x, tiles_y), &[])
}

impl Stage for SeeThrough {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        declare(plan, &self.job, self.job.clipped_depth())
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let (job, config) = (&self.job, &self.job.config);
        let window_from_camera = moment.in_window(moment.pose.map_from_sensor(), config.ground_z_m);
        let [x, y, z] = rows(window_from_camera.inverse());
        let [lens_a, lens_b] = lens(&job.depth);
        let [focal_px, centre_px] = pinhole(&job.depth);
        let [origin_slot_x, origin_slot_y] = moment.window.origin_slot(job.map.side);
        let [first_x, first_y, width, height] =
            view::cells_in_view(self.field, window_from_camera, config, job.map.side);
        input.limit(GATHER.name, Invocations::area(width, height))?;
        let params = SeeThroughGatherParams {
            camera_from_window_x: x,
            camera_from_window_y: y,
            camera_from_window_z: z,
            lens_a,
            lens_b,
            focal_px,
            centre_px,
            field_min: self.field[0],
            field_max: self.field[1],
            camera_xy_m: window_from_camera.translation_m.truncate().as_vec2(),
            width: job.depth.width,
            height: job.depth.height,
            side: job.map.side,
            origin_slot_x,
            origin_slot_y,
            min_hits: config.min_hits,
            resolution_m: single(config.resolution_m),
            mark_range_m: single(config.mark_range_m),
            height_min_m: single(config.height_min_m),
            height_max_m: single(config.height_max_m),
            tau: single(config.tau),
            tiles_x: tiles(&job.depth)[0],
            first_x,
            first_y,
        };
        if !job.counts_trust() {
            let [tiles_x, tiles_y] = tiles(&job.depth);
            let in_tiles = SeeThroughTilesParams { width: job.depth.width, tiles_x, tiles_y, pad: 0 };
            input.set("see_through_tiles_params", &in_tiles)?;
            input.set("see_through_around_params", &SeeThroughAroundParams { tiles_x, tiles_y })?;
        }
        input.set("see_through_gather_params", &params)
    }
}
