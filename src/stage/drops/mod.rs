//! Places where the ground drops away (spec 6 §2): stairs down, the edge of a platform, a trench.
//!
//! Every ray that comes down meets the ground's height somewhere, and votes for the cell there: it ends on the ground, or it goes on
//! to what lies more than `drop_m` deeper. A cell nearly all of whose votes go deeper is a drop, if an edge lies before it: ground,
//! and then at once what is deep, so that neither a ramp down nor a near floor that a stereo matcher gets wrong is one.
//!
//! A mirror image in a glossy floor lies below it too. Its thing lies as far above the ground: where the sensor sees something there,
//! the point is an image; where it looks past that place, the point is real; where it does not look there, the point counts only if
//! no ground shows behind it nor on both sides, and if it belongs to a level floor, less deep than a ceiling is high. Depth that ends
//! at a known pane (`pane_clip`) does not vote, and points that a pane mirrors end on it (`glass/clean`).
//!
//! It takes several messages: those that show a drop in a cell, less those that show the ground there, are counted.

use std::sync::Arc;

use glam::{Vec2, Vec4};

use crate::base::{Result, Rigid};
use crate::config::Config;
use crate::gpu::{FrameInput, Invocations, Plan};
use crate::sensor::Distortion;
use crate::stage::camera::see_through::{lens, pinhole};
use crate::stage::lidar::intensity_layers::SECTORS;
use crate::stage::map::layers::Layers;
use crate::stage::{CameraJob, LidarJob, Moment, SensorJob, Stage, rows, single};

mod shaders;

pub use shaders::{ALL, DECIDE, JUDGE, PIXELS, RETURNS, RETURNS_OF_BUFFER, VIEW, VIEW_OF_BUFFER};

/// Bins of slopes in a sector of directions (`VIEW_BINS`).
pub const VIEW_BINS: u32 = 128;

/// Words of a cell's votes (`MARK_WORDS`).
const MARK_WORDS: u64 = 4;

/// Pixels that are looked at, at most; of larger images every n-th along rows and columns.
const MOST_PIXELS: u32 = 20_000;

/// Points of a scan that are looked at, at most: the votes of a cell fit in 16 bits.
pub const MOST_POINTS: u32 = 65_535;

/// Votes in a cell and around it that make a drop in one message: of a camera, of a lidar.
const CAMERA_VOTES: u32 = 3;
const LIDAR_VOTES: u32 = 2;

/// How far before a drop the ground must be seen, metres: a camera sees the floor up to the edge, of a lidar the last ring on it
/// may lie farther off.
const CAMERA_EDGE_M: f64 = 0.7;
const LIDAR_EDGE_M: f64 = 2.5;

/// Messages, more than speak against it, that make a drop: a camera's come often, and some are wrong.
const CAMERA_MESSAGES: u32 = 6;
const LIDAR_MESSAGES: u32 = 3;

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
        /// Coefficients of the lens.
        pub lens_a: Vec4,
        /// The others.
        pub lens_b: Vec4,
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
        /// Pixels, or points, from one to the next.
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
        /// What lies this little above the ground is ground.
        pub floor_m: f32,
        /// Weights up to this count for nothing.
        pub tau: f32,
        /// Tick of the message.
        pub tick: u32,
        /// The sensor's number, + 1.
        pub sensor: u32,
        /// Votes in a cell and around it that make a drop in one message.
        pub least_votes: u32,
        /// How far before a drop the ground must be seen.
        pub edge_m: f32,
        /// Messages, more than speak against it, that make a drop.
        pub drops_after: u32,
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
        let stride = measured.div_ceil(MOST_POINTS).max(1);
        let [origin_slot_x, origin_slot_y] = moment.origin_slot;
        Self {
            window_from_sensor_x: x,
            window_from_sensor_y: y,
            window_from_sensor_z: z,
            lens_a: Vec4::ZERO,
            lens_b: Vec4::ZERO,
            focal_px: Vec2::ONE,
            centre_px: Vec2::ZERO,
            width: 1,
            measured,
            columns: measured / stride,
            rows: 1,
            stride,
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
            least_votes: LIDAR_VOTES,
            edge_m: single(LIDAR_EDGE_M),
            drops_after: LIDAR_MESSAGES,
            pad0: 0,
            pad1: 0,
        }
    }

    /// Those of a frame of a camera.
    pub fn of_frame(job: &CameraJob, moment: &DropMoment) -> Self {
        let [focal_px, centre_px] = pinhole(&job.depth);
        let [lens_a, lens_b] = lens(&job.depth);
        let (width, height) = (job.depth.width, job.depth.height);
        let stride = stride(width, height);
        Self {
            lens_a,
            lens_b,
            focal_px,
            centre_px,
            width,
            columns: width.div_ceil(stride),
            rows: height.div_ceil(stride),
            stride,
            range_m: single(job.config.mark_range_m),
            least_votes: CAMERA_VOTES,
            edge_m: single(CAMERA_EDGE_M),
            drops_after: CAMERA_MESSAGES,
            ..Self::of_scan(&job.config, moment, width * height)
        }
    }
}

/// Pixels from one that is looked at to the next, along rows and columns.
fn stride(width: u32, height: u32) -> u32 {
    let looked_at = |stride: &u32| width.div_ceil(*stride) * height.div_ceil(*stride);
    (1..).find(|stride| looked_at(stride) <= MOST_PIXELS).unwrap_or(1)
}

/// The stage.
#[derive(Debug)]
pub struct Drops {
    of: SensorJob,
}

impl Drops {
    /// Of a camera's frames.
    pub fn of_camera(job: &Arc<CameraJob>) -> Self {
        Self { of: SensorJob::Camera(Arc::clone(job)) }
    }

    /// Of a lidar's scans.
    pub fn of_lidar(job: &Arc<LidarJob>) -> Self {
        Self { of: SensorJob::Lidar(Arc::clone(job)) }
    }

    fn vote(&self, plan: &mut Plan) -> Result<()> {
        match &self.of {
            SensorJob::Camera(job) => {
                let stride = stride(job.depth.width, job.depth.height);
                let looked_at =
                    Invocations::area(job.depth.width.div_ceil(stride), job.depth.height.div_ceil(stride));
                plan.step(PIXELS, looked_at, &[("depth_m", job.clipped_depth())])?;
                let distorted = job.depth.distortion != Distortion::None;
                plan.with(&[("distorted", distorted), ("fisheye", job.depth.distortion.is_fisheye())])
            }
            SensorJob::Lidar(job) => {
                plan.zeroed("drop_view", 4 * u64::from(SECTORS * VIEW_BINS))?;
                let (view, returns, points) = match job.glass.is_some() {
                    true => (VIEW_OF_BUFFER, RETURNS_OF_BUFFER, "clean_points"),
                    false => (VIEW, RETURNS, "points"),
                };
                let looked_at = Invocations::line(job.capacity.min(MOST_POINTS));
                plan.step(view, looked_at, &[("points", points)])?;
                plan.step(returns, looked_at, &[("points", points)])
            }
        }
    }
}

impl Stage for Drops {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let side = self.of.map().side;
        let cells = u64::from(side) * u64::from(side);
        Layers { drops: true, ..Layers::default() }.declare(plan, side)?;
        plan.uniform::<DropParams>("drop_params")?;
        plan.zeroed("drop_marks", 4 * MARK_WORDS * cells)?;
        plan.scratch("drop_said", 4 * cells)?;
        self.vote(plan)?;
        plan.step(JUDGE, Invocations::area(side, side), &[])?;
        plan.step(DECIDE, Invocations::area(side, side), &[])
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let placed = moment.in_window(moment.pose.map_from_sensor(), self.of.zero_z_m(moment));
        let drops = DropMoment {
            window_from_sensor: placed,
            side: self.of.map().side,
            origin_slot: moment.window.origin_slot(self.of.map().side),
            tick: moment.tick,
            sensor: self.of.sensor(),
        };
        let params = match &self.of {
            SensorJob::Camera(job) => DropParams::of_frame(job, &drops),
            SensorJob::Lidar(job) => {
                let points = u32::try_from(moment.scan()?.points.len()).unwrap_or(job.capacity);
                let params = DropParams::of_scan(&job.config, &drops, points);
                input.limit(VIEW.name, Invocations::line(params.columns))?;
                input.limit(RETURNS.name, Invocations::line(params.columns))?;
                params
            }
        };
        input.set("drop_params", &params)
    }
}
