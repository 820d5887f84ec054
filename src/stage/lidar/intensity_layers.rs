//! Points into the layers that their heights lie in (spec 2 §2).

use std::sync::Arc;

use glam::{Vec2, Vec4};

use crate::base::Result;
use crate::config::{Config, MAX_TALL_LAYERS};
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::sensor::Point;
use crate::stage::lidar::Placed;
use crate::stage::{LidarJob, Moment, Stage, rows, single};

/// The pass over points as the host uploads them, in a texture.
pub const INTENSITY_LAYERS: ShaderSource = ShaderSource {
    name: "intensity_layers",
    parts: &[
        include_str!("../../../shaders/lib/numbers.wgsl"),
        include_str!("../../../shaders/lib/scan.wgsl"),
        include_str!("../../../shaders/lib/points/texture.wgsl"),
        include_str!("../../../shaders/lib/points/placed.wgsl"),
        include_str!("../../../shaders/lib/crossing/add_none.wgsl"),
        include_str!("../../../shaders/intensity_layers.wgsl"),
    ],
};

/// The same with `beam_reach`, for a map with cameras.
pub const INTENSITY_LAYERS_AND_BEAMS: ShaderSource = ShaderSource {
    name: "intensity_layers",
    parts: &[
        include_str!("../../../shaders/lib/numbers.wgsl"),
        include_str!("../../../shaders/lib/scan.wgsl"),
        include_str!("../../../shaders/lib/points/texture.wgsl"),
        include_str!("../../../shaders/lib/points/placed.wgsl"),
        include_str!("../../../shaders/lib/crossing/bins.wgsl"),
        include_str!("../../../shaders/lib/crossing/add.wgsl"),
        include_str!("../../../shaders/intensity_layers.wgsl"),
    ],
};

/// The pass over points that another pass left in a buffer.
pub const INTENSITY_LAYERS_OF_BUFFER: ShaderSource = ShaderSource {
    name: "intensity_layers",
    parts: &[
        include_str!("../../../shaders/lib/numbers.wgsl"),
        include_str!("../../../shaders/lib/scan.wgsl"),
        include_str!("../../../shaders/lib/points/buffer.wgsl"),
        include_str!("../../../shaders/lib/points/placed.wgsl"),
        include_str!("../../../shaders/lib/crossing/add_none.wgsl"),
        include_str!("../../../shaders/intensity_layers.wgsl"),
    ],
};

/// The same with `beam_reach`, for a map with cameras.
pub const INTENSITY_LAYERS_AND_BEAMS_OF_BUFFER: ShaderSource = ShaderSource {
    name: "intensity_layers",
    parts: &[
        include_str!("../../../shaders/lib/numbers.wgsl"),
        include_str!("../../../shaders/lib/scan.wgsl"),
        include_str!("../../../shaders/lib/points/buffer.wgsl"),
        include_str!("../../../shaders/lib/points/placed.wgsl"),
        include_str!("../../../shaders/lib/crossing/bins.wgsl"),
        include_str!("../../../shaders/lib/crossing/add.wgsl"),
        include_str!("../../../shaders/intensity_layers.wgsl"),
    ],
};

/// Texels of a row of the points' texture, two to a point, as in `shaders/lib/points/texture.wgsl`.
pub const POINT_ROW: u32 = 1024;

/// Sectors around the lidar, as in `shaders/lib/scan.wgsl`.
pub const SECTORS: u32 = 720;

/// Words of a sector's beams: a bin for each slope and a bit for each bin, as in `shaders/lib/crossing/bins.wgsl`.
pub const SECTOR_WORDS: u32 = 128 + 4;

/// Fixed-point one of intensities, as in `shaders/lib/scan.wgsl`.
pub const INTENSITY_STEPS: u32 = 4080;

/// Height below all returns.
const NO_FLOOR_M: f64 = -1e9;

/// Vectors of four that hold the bounds of the tall layers.
pub const HEIGHTS: usize = (MAX_TALL_LAYERS + 1).div_ceil(4);

crate::params! {
    /// Parameters of `intensity_layers`.
    pub struct IntensityLayersParams {
        /// First row of window from lidar.
        pub window_from_lidar_x: Vec4,
        /// Second row.
        pub window_from_lidar_y: Vec4,
        /// Third row; z = 0 is the lidar's height.
        pub window_from_lidar_z: Vec4,
        /// Axis of the lidar's turn, and its angle.
        pub turn_axis: Vec4,
        /// The lidar's way, and 1 / its duration.
        pub turn_way: Vec4,
        /// Bounds of the tall layers.
        pub heights: [Vec4; HEIGHTS],
        /// The lidar in the window at the stamp.
        pub lidar: Vec2,
        /// Time of the first point.
        pub first_s: f32,
        /// Points of the scan.
        pub points: u32,
        /// Cells along a side.
        pub side: u32,
        /// Side of a cell.
        pub resolution_m: f32,
        /// Tall layers.
        pub tall: u32,
        /// 1 / full scale of intensities.
        pub per_unit: f32,
        /// Ring of the plane z = 0.
        pub plane_ring: u32,
        /// Ring of the plane z = -epsilon.
        pub below_ring: u32,
        /// Height of the lower plane, for slabs.
        pub below_m: f32,
        /// Half the thickness of a slab.
        pub half_thickness_m: f32,
        /// Intensity from which a return clears glass before it.
        pub clear_steps: u32,
        /// 1: a return that stands counts as full scale, whatever its intensity.
        pub standing: u32,
        /// Height above the lidar up to which a return does not stand.
        pub floor_m: f32,
        /// What lies this near a ground that was seen is floor.
        pub ground_band_m: f32,
    }
}

/// The bounds of the tall layers as shaders take them.
pub fn heights(job: &LidarJob) -> [Vec4; HEIGHTS] {
    let bounds = &job.config.layer_heights_m;
    let bound = |at: usize| single(bounds.get(at).or(bounds.last()).copied().unwrap_or(0.0));
    std::array::from_fn(|v| Vec4::new(bound(4 * v), bound(4 * v + 1), bound(4 * v + 2), bound(4 * v + 3)))
}

/// Height above a lidar at `lidar_z_m` of the map up to which a return is the floor's. Where the map's ground is no lower than
/// that below the lidar, nothing is known of the floor: a lidar does not stand in it. Then every return stands.
pub fn floor_m(config: &Config, lidar_z_m: f64) -> f64 {
    if has_floor(config, lidar_z_m) { to_floor_m(config, lidar_z_m) } else { NO_FLOOR_M }
}

/// Whether the stated ground lies below a lidar at `lidar_z_m` of the map.
pub fn has_floor(config: &Config, lidar_z_m: f64) -> bool {
    to_floor_m(config, lidar_z_m) < 0.0
}

fn to_floor_m(config: &Config, lidar_z_m: f64) -> f64 {
    config.ground_z_m + config.height_min_m - lidar_z_m
}

/// The parameters of one scan.
pub fn params(job: &LidarJob, moment: &Moment<'_>) -> Result<IntensityLayersParams> {
    let config = &job.config;
    let placed = Placed::of(moment, job.deskew);
    let [x, y, z] = rows(placed.window_from_lidar);
    let (turn_axis, turn_way, first_s) = placed.turn.map_or((Vec4::X, Vec4::ZERO, 0.0), |turn| {
        let per_s = if turn.duration_s > 0.0 { 1.0 / turn.duration_s } else { 0.0 };
        let axis = turn.axis.extend(turn.angle_rad).as_vec4();
        (axis, turn.way_m.extend(per_s).as_vec4(), single(turn.first_s))
    });
    let [plane_ring, below_ring] = job.plane_rings.unwrap_or([Point::UNKNOWN; 2]);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates; from 0 up")]
    let clear_steps = (config.transparent_clear * f64::from(INTENSITY_STEPS)).ceil() as u32;
    Ok(IntensityLayersParams {
        window_from_lidar_x: x,
        window_from_lidar_y: y,
        window_from_lidar_z: z,
        turn_axis,
        turn_way,
        heights: heights(job),
        lidar: placed.lidar_in_window_m.as_vec2(),
        first_s,
        points: u32::try_from(moment.scan()?.points.len()).unwrap_or(job.capacity),
        side: job.map.side,
        resolution_m: single(config.scan_resolution_m),
        tall: job.tall_layers(),
        per_unit: single(1.0 / job.full_scale),
        plane_ring: plane_ring.into(),
        below_ring: below_ring.into(),
        below_m: single(-config.plane_below_m),
        half_thickness_m: single(config.plane_half_thickness_m),
        clear_steps: if clear_steps == 0 { u32::MAX } else { clear_steps },
        standing: u32::from(moment.standing),
        floor_m: single(floor_m(config, placed.lidar_z_m)),
        ground_band_m: single(config.height_min_m),
    })
}

/// Declares the points as the host uploads them.
///
/// # Errors
/// [`crate::Error::Plan`] where that was done before.
pub fn upload_points(plan: &mut Plan, capacity: u32) -> Result<()> {
    plan.upload_texture("points", POINT_ROW, (2 * capacity).div_ceil(POINT_ROW)).map(|_| ())
}

/// Declares the layers and the sectors of a scan, and appends the pass over `points`, with `beam_reach` where the map has
/// `cameras`.
///
/// # Errors
/// From the plan.
pub fn declare(plan: &mut Plan, job: &LidarJob, cameras: bool) -> Result<()> {
    plan.uniform::<IntensityLayersParams>("intensity_layers_params")?;
    plan.zeroed("layer_sums", job.grid_bytes(8 * u64::from(job.layer_count())))?;
    plan.zeroed("sector_range", 8 * u64::from(SECTORS))?;
    if cameras {
        plan.zeroed("beam_reach", 4 * u64::from(SECTORS * SECTOR_WORDS))?;
    }
    let (pass, points) = match (job.glass.is_some(), cameras) {
        (true, true) => (INTENSITY_LAYERS_AND_BEAMS_OF_BUFFER, "clean_points"),
        (true, false) => (INTENSITY_LAYERS_OF_BUFFER, "clean_points"),
        (false, true) => (INTENSITY_LAYERS_AND_BEAMS, "points"),
        (false, false) => (INTENSITY_LAYERS, "points"),
    };
    plan.step(pass, Invocations::line(job.capacity), &[("points", points)])?;
    let clearing = job.config.transparent_clear > 0.0;
    plan.with(&[("deskewed", job.deskew), ("ringed", job.plane_rings.is_some()), ("clearing", clearing)])
}

/// The stage.
#[derive(Debug)]
pub struct IntensityLayers {
    /// What it is built for.
    pub job: Arc<LidarJob>,
}

impl Stage for IntensityLayers {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        declare(plan, &self.job, self.job.map.layers.cameras)
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let params = params(&self.job, moment)?;
        input.write("points", bytemuck::cast_slice(&moment.scan()?.points))?;
        input.limit(INTENSITY_LAYERS.name, Invocations::line(params.points))?;
        input.set("intensity_layers_params", &params)
    }
}
