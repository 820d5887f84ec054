//! One thing that a sensor saw, with where the robot was.

use glam::DVec2;

use crate::base::Rigid;
use crate::sensor::{FramePose, RgbdFrame, Scan};

/// Where base and sensor were when a sensor saw something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorPose {
    /// Robot base in the map at the stamp.
    pub map_from_base: Rigid,
    /// The sensor in the robot base: a depth camera's optical frame, a lidar's own.
    pub base_from_sensor: Rigid,
    /// The sensor at the times of the first and the last point, where points carry time and the sensor moved.
    pub sweep: Option<Sweep>,
}

impl SensorPose {
    /// A map that is the sensor's own frame.
    pub const SENSOR: Self =
        Self { map_from_base: Rigid::IDENTITY, base_from_sensor: Rigid::IDENTITY, sweep: None };

    /// The sensor in the map at the stamp.
    pub fn map_from_sensor(&self) -> Rigid {
        self.map_from_base.then(self.base_from_sensor)
    }

    /// Whether every number of it is finite.
    pub fn is_finite(&self) -> bool {
        let finite = |rigid: Rigid| rigid.rotation.is_finite() && rigid.translation_m.is_finite();
        let swept =
            self.sweep.is_none_or(|sweep| finite(sweep.map_from_first) && finite(sweep.map_from_last));
        finite(self.map_from_base) && finite(self.base_from_sensor) && swept
    }
}

impl From<FramePose> for SensorPose {
    fn from(FramePose { map_from_base, base_from_camera }: FramePose) -> Self {
        Self { map_from_base, base_from_sensor: base_from_camera, sweep: None }
    }
}

/// A sensor's motion during a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sweep {
    /// Time of the first point after the scan's stamp, seconds.
    pub first_s: f32,
    /// Time of the last point after the scan's stamp, seconds.
    pub last_s: f32,
    /// The sensor in the map at the first.
    pub map_from_first: Rigid,
    /// The sensor in the map at the last.
    pub map_from_last: Rigid,
}

/// What a sensor measured.
#[derive(Debug, Clone, PartialEq)]
pub enum SensorData {
    /// Of a camera.
    Frame(Box<RgbdFrame>),
    /// Of a lidar; its points are in the lidar's frame.
    Scan(Scan),
}

/// A sensor's data with what a source says of the robot at that time.
///
/// A program that has its own sensors fills one in; that of a recording comes from a [`Source`](crate::input::Source).
///
/// ```
/// use limpid::Observation;
/// use limpid::sensor::{Columns, Dropped, Scan, SensorData, SensorPose};
///
/// let points = Vec::new(); // what the lidar measured
/// let (columns, dropped) = (Columns { ring: true, ..Columns::default() }, Dropped::default());
/// let (stamp_ns, frame_id) = (1_000_000_000, "top".into());
/// let scan = Scan { index: 0, stamp_ns, frame_id, points, columns, dropped };
/// let seen = Observation {
///     sensor: 0,
///     pose: Some(SensorPose::SENSOR),
///     map_frame: "odom".into(),
///     goal_m: None,
///     data: SensorData::Scan(scan),
/// };
/// assert_eq!(seen.stamp_ns(), 1_000_000_000);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Observation {
    /// Which sensor, counted as the source lists them.
    pub sensor: usize,
    /// Where base and sensor were; `None` where that is unknown at this stamp.
    pub pose: Option<SensorPose>,
    /// Frame of the map: `map_frame`, or the sensor's own where there are no poses at all.
    pub map_frame: String,
    /// The robot's goal in the map, metres; `None`: straight ahead.
    pub goal_m: Option<DVec2>,
    /// What was measured.
    pub data: SensorData,
}

impl Observation {
    /// A camera's frame, with the pose that it bears.
    pub fn of_frame(sensor: usize, map_frame: &str, frame: RgbdFrame) -> Self {
        Self {
            sensor,
            pose: frame.pose.map(SensorPose::from),
            map_frame: map_frame.into(),
            goal_m: None,
            data: SensorData::Frame(Box::new(frame)),
        }
    }

    /// Number in its source, counted for each sensor from 0: of the depth image, or of the scan.
    pub fn index(&self) -> u64 {
        match &self.data {
            SensorData::Frame(frame) => frame.index,
            SensorData::Scan(scan) => scan.index,
        }
    }

    /// Stamp of the depth image, or of the scan, nanoseconds.
    pub fn stamp_ns(&self) -> u64 {
        match &self.data {
            SensorData::Frame(frame) => frame.depth.stamp_ns,
            SensorData::Scan(scan) => scan.stamp_ns,
        }
    }

    /// The frame, where it is a camera's.
    pub fn frame(&self) -> Option<&RgbdFrame> {
        match &self.data {
            SensorData::Frame(frame) => Some(frame),
            SensorData::Scan(_) => None,
        }
    }

    /// The scan, where it is a lidar's.
    pub fn scan(&self) -> Option<&Scan> {
        match &self.data {
            SensorData::Frame(_) => None,
            SensorData::Scan(scan) => Some(scan),
        }
    }
}
