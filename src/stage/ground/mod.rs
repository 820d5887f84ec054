//! The ground under the robot (spec 6 §2): a plane for each sensor, from what it sees, from which the passes after it count heights.
//!
//! Several sensors share one vertical datum: the floor itself. Each counts heights from the floor as it sees it, so that an
//! error of its mount does not lift its points off the ground; a sensor that does not see the floor takes the plane of the one
//! that sees most of it, and where no sensor does, the ground is the stated one. What is used in a message is what is known
//! with that message: the passes run in its submission, and nothing is read back for it.
//!
//! A plane is taken for the ground if it lies below the sensor and is level enough, if enough was seen of it, and if hardly any
//! beam passes beside it to something below (a table). It must lie where the robot's base can stand, go on from what was
//! known, and not contradict another sensor. A mirror image in a glossy floor lies below it, but its beams cross the floor where
//! that is seen: it speaks against nothing.

use std::sync::Arc;

use glam::{DVec3, Vec2, Vec4};

use crate::base::{Result, Rigid};
use crate::config::{Config, GroundSource};
use crate::gpu::{Extent, FrameInput, Invocations, Plan};
use crate::map::Clock;
use crate::sensor::{CameraModel, Distortion, SensorPose};
use crate::stage::camera::see_through::pinhole;
use crate::stage::{CameraJob, LidarJob, Moment, SensorJob, Stage, rows, single};

mod shaders;

pub use shaders::{ALL, DRAW, PIXELS, RETURNS, SCORE, SETTLE};

/// Samples of a message, at most (`MOST_SAMPLES`).
pub const MOST_SAMPLES: u32 = 2048;
/// Samples in a row of their texture (`SAMPLE_ROW`).
pub const SAMPLE_ROW: u32 = 64;
/// Planes that are drawn for a message (`HYPOTHESES`).
pub const HYPOTHESES: u32 = 128;
/// Planes that one invocation of `ground/score` counts (`TOGETHER`), and invocations that count one (`PARTS`).
const SCORED_TOGETHER: u32 = 8;
const SCORE_PARTS: u32 = 16;
/// Bytes that are kept for a sensor (`Kept`), and of what is told of a message (`ground_now`).
const KEPT_BYTES: u64 = 32;
const NOW_BYTES: u64 = 80;

/// Steepest ground where tf says what is up, and where the sensor's own axes must do, degrees.
const MOST_TILT_DEG: f64 = 15.0;
const MOST_OWN_TILT_DEG: f64 = 30.0;
/// Side of the squares by which planes are measured: a camera's pixels lie dense, a lidar's rings do not.
const CAMERA_SQUARE_M: f64 = 0.25;
const LIDAR_SQUARE_M: f64 = 0.5;
/// Lowest mount: what a lidar is put on lies nearer below it, and its beams nearly level with that.
const CAMERA_HEIGHT_M: f64 = 0.05;
const LIDAR_HEIGHT_M: f64 = 0.25;
/// Differences up to this are noise: then the stated ground is taken as it is.
const AGREES_M: f64 = 0.06;
/// The same as a share of the height band's lower edge.
const AGREES_SHARE: f64 = 0.6;
/// A base nearer to its sensor is the sensor.
const LEAST_APART_M: f64 = 0.05;

crate::params! {
    /// Parameters of all passes of the ground.
    pub struct GroundParams {
        /// First row of the sensor in the map's axes from the local origin.
        pub local_from_sensor_x: Vec4,
        /// Second row.
        pub local_from_sensor_y: Vec4,
        /// Third row.
        pub local_from_sensor_z: Vec4,
        /// The base from the sensor in the map's axes; w: how it is known.
        pub base: Vec4,
        /// Corner of cell (0, 0) from the local origin, and the height from which the passes after it count z.
        pub zero: Vec4,
        /// Focal lengths.
        pub focal_px: Vec2,
        /// Principal point.
        pub centre_px: Vec2,
        /// Pixels of a row.
        pub width: u32,
        /// Pixels, or points.
        pub measured: u32,
        /// Samples in a row.
        pub columns: u32,
        /// Rows of samples.
        pub rows: u32,
        /// Pixels, or points, to a sample.
        pub stride: u32,
        /// Tick of the message.
        pub tick: u32,
        /// Ticks for which a plane is believed that is not seen.
        pub keep_ticks: u32,
        /// The sensor's number, from 0.
        pub sensor: u32,
        /// Sensors of the map.
        pub sensors: u32,
        /// Whether tf gives the sensor in a map: 0 or 1.
        pub has_map: u32,
        /// Weights up to this count for nothing.
        pub tau: f32,
        /// Tangent of the steepest ground.
        pub most_slope: f32,
        /// Height of the stated ground from the local origin.
        pub stated_z: f32,
        /// Side of the squares by which planes are measured.
        pub square_m: f32,
        /// Difference to the stated ground up to which that is taken, where the plane is seen.
        pub agrees_m: f32,
        /// Least height of the sensor above the ground.
        pub least_height_m: f32,
    }
}

/// What a sensor measured, as the passes sample it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sampled {
    /// A depth image.
    Pixels(CameraModel),
    /// So many points of a scan.
    Points(u32),
}

impl Sampled {
    /// Columns and rows of samples, and the stride from one to the next.
    fn layout(self) -> [u32; 3] {
        match self {
            Self::Pixels(CameraModel { width, height, .. }) => {
                let samples = |stride: &u32| width.div_ceil(*stride) * height.div_ceil(*stride);
                let stride = (1..).find(|stride| samples(stride) <= MOST_SAMPLES).unwrap_or(1);
                [width.div_ceil(stride), height.div_ceil(stride), stride]
            }
            Self::Points(points) => {
                let stride = points.div_ceil(MOST_SAMPLES).max(1);
                [points / stride, 1, stride]
            }
        }
    }
}

/// What the parameters of one message are made of.
#[derive(Debug, Clone, Copy)]
pub struct GroundMoment<'a> {
    /// Parameters.
    pub config: &'a Config,
    /// What was measured.
    pub sampled: Sampled,
    /// Where base and sensor were.
    pub pose: SensorPose,
    /// Place in the map from which kept planes count.
    pub local_origin_m: DVec3,
    /// Corner of cell (0, 0) in the map, and the height from which the passes after it count z.
    pub zero_m: DVec3,
    /// Tick of the message.
    pub tick: u32,
    /// The sensor's number, from 0.
    pub sensor: u32,
    /// Sensors of the map.
    pub sensors: u32,
}

/// The base from the sensor in the map's axes; w: 0 where it is the sensor, 1 where it is as if assumed to stand on the stated ground
/// right under it, 2 where it is known.
fn base_of(pose: SensorPose, ground_z_m: f64) -> Vec4 {
    let Rigid { translation_m: base_m, .. } = pose.map_from_base;
    let off_m = base_m - pose.map_from_sensor().translation_m;
    let assumed = off_m.truncate().length() < 1e-6 && (base_m.z - ground_z_m).abs() < 1e-6;
    let known_as = match (off_m.length() > LEAST_APART_M, assumed) {
        (false, _) => 0.0,
        (true, true) => 1.0,
        (true, false) => 2.0,
    };
    off_m.as_vec3().extend(known_as)
}

/// The parameters of one message.
pub fn params(moment: &GroundMoment<'_>) -> GroundParams {
    let &GroundMoment { config, sampled, pose, local_origin_m, zero_m, .. } = moment;
    let map_from_sensor = pose.map_from_sensor();
    let translation_m = map_from_sensor.translation_m - local_origin_m;
    let [x, y, z] = rows(Rigid { translation_m, ..map_from_sensor });
    let [columns, sample_rows, stride] = sampled.layout();
    let has_map = pose != SensorPose::SENSOR;
    let tilt_deg = if has_map { MOST_TILT_DEG } else { MOST_OWN_TILT_DEG };
    let (width, measured, [focal_px, centre_px]) = match sampled {
        Sampled::Pixels(camera) => (camera.width, camera.width * camera.height, pinhole(&camera)),
        Sampled::Points(points) => (1, points, [Vec2::ONE; 2]),
    };
    let (square_m, least_height_m) = match sampled {
        Sampled::Pixels(_) => (CAMERA_SQUARE_M, CAMERA_HEIGHT_M),
        Sampled::Points(_) => (LIDAR_SQUARE_M, LIDAR_HEIGHT_M),
    };
    GroundParams {
        local_from_sensor_x: x,
        local_from_sensor_y: y,
        local_from_sensor_z: z,
        base: base_of(pose, config.ground_z_m),
        zero: (zero_m - local_origin_m).as_vec3().extend(0.0),
        focal_px,
        centre_px,
        width,
        measured,
        columns,
        rows: sample_rows,
        stride,
        tick: moment.tick,
        keep_ticks: Clock::ticks(config.ground_keep_s),
        sensor: moment.sensor,
        sensors: moment.sensors,
        has_map: u32::from(has_map),
        tau: single(config.tau),
        most_slope: single(tilt_deg.to_radians().tan()),
        stated_z: single(config.ground_z_m - local_origin_m.z),
        square_m: single(square_m),
        agrees_m: single(AGREES_M.min(AGREES_SHARE * config.height_min_m)),
        least_height_m: single(least_height_m),
    }
}

/// What heights count from where the ground is the stated one, which lies `below_zero_m` under the height that a pass counts z
/// from: `ground_now`.
pub fn stated_now(below_zero_m: f64) -> [[f32; 4]; 5] {
    const NO_PLANE: [f32; 4] = [0.0, 0.0, 0.0, 1.0e9];
    [[0.0, 0.0, 1.0, single(below_zero_m)], [0.0; 4], NO_PLANE, [0.0; 4], NO_PLANE]
}

/// The buffers of a map with so many sensors.
fn declare(plan: &mut Plan, sensors: u64) -> Result<()> {
    plan.uniform::<GroundParams>("ground_params")?;
    plan.shared("ground", KEPT_BYTES * sensors)?;
    let height = MOST_SAMPLES / SAMPLE_ROW;
    plan.texture("ground_samples", Extent { width: SAMPLE_ROW, height, layers: 1 })?;
    plan.scratch("ground_planes", 16 * u64::from(HYPOTHESES))?;
    plan.scratch("ground_scores", 4 * u64::from(HYPOTHESES))?;
    plan.product("ground_now", NOW_BYTES).map(|_| ())
}

fn sample_scan(plan: &mut Plan) -> Result<()> {
    plan.step(RETURNS, Invocations::line(MOST_SAMPLES), &[])
}

/// From samples to `ground_now`.
fn fit(plan: &mut Plan) -> Result<()> {
    plan.step(DRAW, Invocations::line(HYPOTHESES), &[])?;
    plan.step(SCORE, Invocations::area(HYPOTHESES / SCORED_TOGETHER, SCORE_PARTS), &[])?;
    plan.step(SETTLE, Invocations::line(1), &[])
}

/// Declares the buffers and appends the passes of a lone lidar's ground, without a map; its parameters are [`params`].
///
/// # Errors
/// [`crate::Error::Plan`], [`crate::Error::Shader`].
pub fn append_alone(plan: &mut Plan) -> Result<()> {
    declare(plan, 1)?;
    sample_scan(plan)?;
    fit(plan)
}

/// The stage.
#[derive(Debug)]
pub struct Ground {
    of: SensorJob,
}

impl Ground {
    /// Of a camera's frames.
    pub fn of_camera(job: &Arc<CameraJob>) -> Self {
        Self { of: SensorJob::Camera(Arc::clone(job)) }
    }

    /// Of a lidar's scans.
    pub fn of_lidar(job: &Arc<LidarJob>) -> Self {
        Self { of: SensorJob::Lidar(Arc::clone(job)) }
    }

    fn sample(&self, plan: &mut Plan) -> Result<()> {
        match &self.of {
            SensorJob::Camera(job) => {
                let depth = [("depth_m", job.depth_buffer())];
                plan.step(PIXELS, Invocations::line(MOST_SAMPLES), &depth)?;
                plan.with(&[("distorted", job.depth.distortion != Distortion::None)])
            }
            SensorJob::Lidar(_) => sample_scan(plan),
        }
    }
}

impl Stage for Ground {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        if self.of.config().ground == GroundSource::Stated {
            return plan.upload("ground_now", NOW_BYTES).map(|_| ());
        }
        declare(plan, u64::try_from(self.of.map().sensors).unwrap_or(1).max(1))?;
        self.sample(plan)?;
        fit(plan)?;
        plan.read_back("ground_now").map(|_| ())
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let config = self.of.config();
        let zero_m = DVec3::new(moment.grid.origin_x_m, moment.grid.origin_y_m, self.of.zero_z_m(moment));
        if config.ground == GroundSource::Stated {
            let now = stated_now(zero_m.z - config.ground_z_m);
            return input.write("ground_now", bytemuck::cast_slice(&now));
        }
        let sampled = match &self.of {
            SensorJob::Camera(job) => Sampled::Pixels(job.depth),
            SensorJob::Lidar(job) => {
                let points = moment.scan()?.points.len();
                Sampled::Points(u32::try_from(points).unwrap_or(job.capacity))
            }
        };
        let moment = GroundMoment {
            config,
            sampled,
            pose: moment.pose,
            local_origin_m: moment.local_origin_m,
            zero_m,
            tick: moment.tick,
            sensor: self.of.sensor(),
            sensors: u32::try_from(self.of.map().sensors).unwrap_or(1).max(1),
        };
        input.set("ground_params", &params(&moment))
    }
}
