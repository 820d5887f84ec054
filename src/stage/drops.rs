//! Places where the ground drops away (spec 6 §2): stairs down, the edge of a platform.
//!
//! A point more than `drop_m` below the ground is a drop, unless something explains it. A mirror image in a glossy floor lies below
//! it too, but its ray crosses the floor where that is seen, in this message or in several before; of a camera, a thing that
//! stands where the image seems to lie is what is mirrored there. A real drop is seen where the ground is not: its rays cross
//! the ground's height beyond the edge. The cell where a ray crosses it is marked as well as the one where it ends, so that the
//! edge is closed as far as it is seen. Depth that ends at a known pane (`pane_clip`) marks nothing, and points that a pane
//! mirrors end on it (`glass/clean`).
//!
//! It takes several messages: the average over messages that say something of a cell (`lambda`) must reach
//! `occupied_threshold`, and messages that show the ground in a cell lower it.

use std::sync::Arc;

use glam::{Vec2, Vec4};

use crate::base::{Result, Rigid};
use crate::config::Config;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::sensor::Distortion;
use crate::stage::camera::see_through::pinhole;
use crate::stage::lidar::intensity_layers::SECTORS;
use crate::stage::map::layers::Layers;
use crate::stage::{CameraJob, LidarJob, MapJob, Moment, Stage, rows, single};

const NUMBERS: &str = include_str!("../../shaders/lib/numbers.wgsl");
const SCAN: &str = include_str!("../../shaders/lib/scan.wgsl");
const CELL: &str = include_str!("../../shaders/lib/cell.wgsl");
const SLOT: &str = include_str!("../../shaders/lib/slot.wgsl");
const RECORD: &str = include_str!("../../shaders/lib/record.wgsl");
const DROPS: &str = include_str!("../../shaders/lib/drops/drops.wgsl");
const HEIGHT: &str = include_str!("../../shaders/lib/drops/height.wgsl");
const MARK: &str = include_str!("../../shaders/lib/drops/mark.wgsl");
const TEXTURE: &str = include_str!("../../shaders/lib/points/texture.wgsl");
const BUFFER: &str = include_str!("../../shaders/lib/points/buffer.wgsl");
const REACH_PASS: &str = include_str!("../../shaders/drops/reach.wgsl");
const RETURNS_PASS: &str = include_str!("../../shaders/drops/returns.wgsl");

/// Pixels below the ground.
pub const PIXELS: ShaderSource = ShaderSource {
    name: "drops/pixels",
    parts: &[CELL, SLOT, DROPS, HEIGHT, MARK, include_str!("../../shaders/drops/pixels.wgsl")],
};
/// Where a scan shows the ground.
pub const REACH: ShaderSource =
    ShaderSource { name: "drops/reach", parts: &[NUMBERS, SCAN, TEXTURE, DROPS, HEIGHT, REACH_PASS] };
/// The same over points that another pass left in a buffer.
pub const REACH_OF_BUFFER: ShaderSource =
    ShaderSource { name: "drops/reach", parts: &[NUMBERS, SCAN, BUFFER, DROPS, HEIGHT, REACH_PASS] };
/// Points below the ground.
pub const RETURNS: ShaderSource = ShaderSource {
    name: "drops/returns",
    parts: &[NUMBERS, SCAN, TEXTURE, SLOT, DROPS, HEIGHT, MARK, RETURNS_PASS],
};
/// The same over points that another pass left in a buffer.
pub const RETURNS_OF_BUFFER: ShaderSource = ShaderSource {
    name: "drops/returns",
    parts: &[NUMBERS, SCAN, BUFFER, SLOT, DROPS, HEIGHT, MARK, RETURNS_PASS],
};
/// What becomes of the layer by a frame.
pub const DECIDE_OF_FRAME: ShaderSource = ShaderSource {
    name: "drops/decide",
    parts: &[
        CELL,
        SLOT,
        RECORD,
        DROPS,
        include_str!("../../shaders/lib/drops/ground_hits.wgsl"),
        include_str!("../../shaders/drops/decide.wgsl"),
    ],
};
/// What becomes of the layer by a scan.
pub const DECIDE_OF_SCAN: ShaderSource = ShaderSource {
    name: "drops/decide",
    parts: &[
        SLOT,
        RECORD,
        DROPS,
        include_str!("../../shaders/lib/drops/ground_marks.wgsl"),
        include_str!("../../shaders/drops/decide.wgsl"),
    ],
};

/// All of them.
pub const ALL: [ShaderSource; 7] =
    [PIXELS, REACH, REACH_OF_BUFFER, RETURNS, RETURNS_OF_BUFFER, DECIDE_OF_FRAME, DECIDE_OF_SCAN];

/// Pixels that are looked at, at most; of larger images every n-th along rows and columns.
const MOST_PIXELS: u32 = 20_000;

/// Points below the ground that make a drop of a cell in one message: of a camera, of a lidar.
const CAMERA_POINTS: u32 = 2;
const LIDAR_POINTS: u32 = 1;

/// Farthest place along the ground at which a lidar's points count, metres: a tilt that is wrong by 0.3 degrees lifts it by 0.05 m.
const LIDAR_RANGE_M: f64 = 10.0;

crate::params! {
    /// Parameters of all passes of drops.
    pub struct DropParams {
        /// First row of window from sensor, as the passes before count.
        pub window_from_sensor_x: Vec4,
        /// Second row.
        pub window_from_sensor_y: Vec4,
        /// Third row.
        pub window_from_sensor_z: Vec4,
        /// Focal lengths.
        pub focal_px: Vec2,
        /// Principal point.
        pub centre_px: Vec2,
        /// Pixels of a row.
        pub width: u32,
        /// Pixels, or points.
        pub measured: u32,
        /// Pixels of a row that are looked at.
        pub columns: u32,
        /// Rows that are looked at.
        pub rows: u32,
        /// Pixels from one to the next.
        pub stride: u32,
        /// Cells along a side.
        pub side: u32,
        /// Slot of window cell (0, 0) along x.
        pub origin_slot_x: u32,
        /// Slot of window cell (0, 0) along y.
        pub origin_slot_y: u32,
        /// Side of a cell.
        pub resolution_m: f32,
        /// Farthest place that counts, along the ground.
        pub range_m: f32,
        /// Depth below the ground from which a place is a drop.
        pub drop_m: f32,
        /// What lies this near the ground is floor.
        pub floor_m: f32,
        /// Weights up to this count for nothing.
        pub tau: f32,
        /// Tick of the message.
        pub tick: u32,
        /// The sensor's number, + 1.
        pub sensor: u32,
        /// Points that make a drop in one message.
        pub min_points: u32,
        /// Share of what was known that a message leaves.
        pub keep_share: f32,
        /// How surely a cell must drop.
        pub threshold: f32,
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
    }
}

/// What the parameters of one message are made of, beside the configuration.
#[derive(Debug, Clone, Copy)]
pub struct DropMoment {
    /// The sensor in the window, as the passes before count: of a camera z = 0 at the stated ground, of a lidar at its height.
    pub window_from_sensor: Rigid,
    /// Cells along a side.
    pub side: u32,
    /// Slot of window cell (0, 0).
    pub origin_slot: [u32; 2],
    /// Tick of the message.
    pub tick: u32,
    /// The sensor's number, from 0.
    pub sensor: u32,
}

impl DropParams {
    /// Those of a message of `measured` points of a lidar; a camera's has its image beside.
    pub fn of_scan(config: &Config, moment: &DropMoment, measured: u32) -> Self {
        let [x, y, z] = rows(moment.window_from_sensor);
        let [origin_slot_x, origin_slot_y] = moment.origin_slot;
        Self {
            window_from_sensor_x: x,
            window_from_sensor_y: y,
            window_from_sensor_z: z,
            focal_px: Vec2::ONE,
            centre_px: Vec2::ZERO,
            width: 1,
            measured,
            columns: measured,
            rows: 1,
            stride: 1,
            side: moment.side,
            origin_slot_x,
            origin_slot_y,
            resolution_m: single(config.resolution_m),
            range_m: single(LIDAR_RANGE_M),
            drop_m: single(config.drop_m),
            floor_m: single(config.height_min_m),
            tau: single(config.tau),
            tick: moment.tick,
            sensor: moment.sensor + 1,
            min_points: LIDAR_POINTS,
            keep_share: single(config.lambda),
            threshold: single(config.occupied_threshold),
            pad0: 0,
            pad1: 0,
        }
    }

    /// Those of a frame of a camera.
    pub fn of_frame(job: &CameraJob, moment: &DropMoment) -> Self {
        let [focal_px, centre_px] = pinhole(&job.depth);
        let (width, height) = (job.depth.width, job.depth.height);
        let stride = stride(width, height);
        Self {
            focal_px,
            centre_px,
            width,
            columns: width.div_ceil(stride),
            rows: height.div_ceil(stride),
            stride,
            range_m: single(job.config.mark_range_m),
            min_points: CAMERA_POINTS,
            ..Self::of_scan(&job.config, moment, width * height)
        }
    }
}

/// Pixels from one that is looked at to the next, along rows and columns.
fn stride(width: u32, height: u32) -> u32 {
    let looked_at = |stride: &u32| width.div_ceil(*stride) * height.div_ceil(*stride);
    (1..).find(|stride| looked_at(stride) <= MOST_PIXELS).unwrap_or(1)
}

/// Whose messages.
#[derive(Debug, Clone)]
enum Of {
    Camera(Arc<CameraJob>),
    Lidar(Arc<LidarJob>),
}

/// The stage.
#[derive(Debug)]
pub struct Drops {
    of: Of,
}

impl Drops {
    /// Of a camera's frames.
    pub fn of_camera(job: &Arc<CameraJob>) -> Self {
        Self { of: Of::Camera(Arc::clone(job)) }
    }

    /// Of a lidar's scans.
    pub fn of_lidar(job: &Arc<LidarJob>) -> Self {
        Self { of: Of::Lidar(Arc::clone(job)) }
    }

    fn map(&self) -> &MapJob {
        match &self.of {
            Of::Camera(job) => &job.map,
            Of::Lidar(job) => &job.map,
        }
    }
}

impl Stage for Drops {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let side = self.map().side;
        let cells = u64::from(side) * u64::from(side);
        Layers { drops: true, ..Layers::default() }.declare(plan, side)?;
        plan.uniform::<DropParams>("drop_params")?;
        plan.zeroed("drop_marks", 8 * cells)?;
        let decide = match &self.of {
            Of::Camera(job) => {
                let stride = stride(job.depth.width, job.depth.height);
                let looked_at =
                    Invocations::area(job.depth.width.div_ceil(stride), job.depth.height.div_ceil(stride));
                plan.step(PIXELS, looked_at, &[("depth_m", job.clipped_depth())])?;
                plan.with(&[("distorted", job.depth.distortion != Distortion::None)])?;
                DECIDE_OF_FRAME
            }
            Of::Lidar(job) => {
                plan.zeroed("floor_reach", 4 * u64::from(SECTORS))?;
                let (reach, returns, points) = match job.glass.is_some() {
                    true => (REACH_OF_BUFFER, RETURNS_OF_BUFFER, "clean_points"),
                    false => (REACH, RETURNS, "points"),
                };
                plan.step(reach, Invocations::line(job.capacity), &[("points", points)])?;
                plan.step(returns, Invocations::line(job.capacity), &[("points", points)])?;
                DECIDE_OF_SCAN
            }
        };
        plan.step(decide, Invocations::area(side, side), &[])
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let map_from_sensor = moment.pose.map_from_sensor();
        let of = |window_from_sensor: Rigid, sensor: u32| DropMoment {
            window_from_sensor,
            side: self.map().side,
            origin_slot: moment.window.origin_slot(self.map().side),
            tick: moment.tick,
            sensor,
        };
        let params = match &self.of {
            Of::Camera(job) => {
                let placed = moment.in_window(map_from_sensor, job.config.ground_z_m);
                DropParams::of_frame(job, &of(placed, job.sensor))
            }
            Of::Lidar(job) => {
                let points = u32::try_from(moment.scan()?.points.len()).unwrap_or(job.capacity);
                input.limit(REACH.name, Invocations::line(points))?;
                input.limit(RETURNS.name, Invocations::line(points))?;
                let placed = moment.in_window(map_from_sensor, map_from_sensor.translation_m.z);
                DropParams::of_scan(&job.config, &of(placed, job.sensor), points)
            }
        };
        input.set("drop_params", &params)
    }
}
