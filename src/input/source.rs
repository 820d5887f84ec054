//! One pass over a recording with several sensors, in order of stamps.

use std::path::Path;

use crate::base::Result;
use crate::config::{Config, SensorInfo};
use crate::input::log::LogSource;
use crate::input::open::log_files;
use crate::input::single::{CameraSource, LidarSource};
use crate::input::{ReadReport, contents, open};
use crate::sensor::{CameraInfo, Dropped, LidarInfo, Observation, SensorData, SensorModel};

/// Depth images read ahead for the first with colour.
const COLOR_AHEAD: u32 = 8;

/// What was met of one sensor, complete once [`Source::next`] has returned `None`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SensorReport {
    /// The sensor's name.
    pub name: String,
    /// Depth images, or scans and messages that give none, seen.
    pub seen: u64,
    /// Observations given.
    pub given: u64,
    /// Points in the scans.
    pub points: u64,
    /// Points left out of the scans, by reason.
    pub dropped: Dropped,
    /// Observations given without a pose.
    pub without_pose: u64,
    /// Depth images, messages and clouds that give no observation.
    pub unusable: u64,
    /// Observations given after newer ones of other sensors.
    pub late: u64,
    /// How often its stamps jumped back by more than a second.
    pub jumps: u64,
}

/// What a source met, complete once [`Source::next`] has returned `None`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SourceReport {
    /// What was passed over, and notes, of all sensors.
    pub read: ReadReport,
    /// By sensor, in the order of [`Source::sensors`].
    pub sensors: Vec<SensorReport>,
}

/// Observations of one or more sensors in order of their stamps as far as it can be known, each sensor's own in the order
/// of its recording; never holds more than a bounded number.
///
/// ```
/// use limpid::{Observation, Result, SensorInfo, Source, input::SourceReport};
///
/// /// Every second observation of another source.
/// struct Half(Box<dyn Source>);
///
/// impl Source for Half {
///     fn sensors(&self) -> &[SensorInfo] {
///         self.0.sensors()
///     }
///     fn next(&mut self) -> Result<Option<Observation>> {
///         let _passed_over = self.0.next()?;
///         self.0.next()
///     }
///     fn report(&self) -> SourceReport {
///         self.0.report()
///     }
///     fn count_hint(&self) -> Option<u64> {
///         self.0.count_hint().map(|count| count / 2)
///     }
/// }
///
/// let mut half = Half(limpid::open_source("testdata/room.mcap".as_ref(), &limpid::Config::default())?);
/// assert_eq!(half.next()?.map(|frame| frame.index()), Some(1));
/// # Ok::<(), limpid::Error>(())
/// ```
pub trait Source {
    /// The sensors, which [`Observation::sensor`] counts; known from the start.
    fn sensors(&self) -> &[SensorInfo];

    /// The next observation, or `None` at the end (a cut-off file ends at its cut, with a note in the report).
    ///
    /// # Errors
    /// Only what ends the recording, such as an unreadable file; single bad messages are counted in the report.
    fn next(&mut self) -> Result<Option<Observation>>;

    /// What was met so far.
    fn report(&self) -> SourceReport;

    /// How many observations the recording says it holds at most, where it says so without being read.
    fn count_hint(&self) -> Option<u64>;

    /// Topics that are read, each with what it is used for: `camera: depth`.
    fn uses(&self) -> Vec<(String, String)> {
        Vec::new()
    }

    /// Whether the user stopped it before its end.
    fn was_stopped(&self) -> bool {
        false
    }
}

/// Opens a recording of any kind: an MCAP file, a ROS 1 bag or a bag of rosbag2 with any number of sensors; a TUM RGB-D folder or a still
/// pair with a camera; a pcap, PLY or PCD file or a folder of these with a lidar.
///
/// The sensors are those of `config.sensors`, each with its own parameters; where it names none, the camera and the lidar
/// that the recording has.
///
/// # Errors
/// [`crate::Error::File`]; [`crate::Error::Format`] for other files and for those that hold no sensor that can be read;
/// [`crate::Error::Config`] for a configured topic that is absent or of another type.
///
/// # Examples
/// ```
/// let mut room = limpid::open_source("testdata/room.mcap".as_ref(), &limpid::Config::default())?;
/// let mut frames = 0;
/// while let Some(observation) = room.next()? {
///     assert!(observation.frame().is_some() && observation.pose.is_some());
///     frames += 1;
/// }
/// assert_eq!(frames, 30);
/// # Ok::<(), limpid::Error>(())
/// ```
pub fn open_source(path: &Path, config: &Config) -> Result<Box<dyn Source>> {
    if let Some(files) = log_files(path, config)? {
        return Ok(Box::new(LogSource::open(files, config)?));
    }
    if contents(path, config)?.lidar {
        return Ok(Box::new(LidarSource::open(path, config)?));
    }
    Ok(Box::new(CameraSource::open(path, config, open)?))
}

impl SensorReport {
    pub(crate) fn new(name: &str, given: Given) -> Self {
        let Given { given, without_pose } = given;
        Self { name: name.into(), given, without_pose, ..Self::default() }
    }
}

/// Counts of observations given.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Given {
    given: u64,
    without_pose: u64,
}

impl Given {
    pub(crate) fn count(&mut self, observation: &Observation) {
        self.given += 1;
        self.without_pose += u64::from(observation.pose.is_none());
    }
}

/// Learns of a sensor by its first observations.
#[derive(Debug)]
pub(crate) struct Learner {
    /// Whether the recording has anything of the sensor.
    there: bool,
    /// Whether it has colour of it.
    has_color: bool,
    /// Frames with a pose seen.
    frames: u32,
}

impl Learner {
    pub(crate) fn new(there: bool, has_color: bool) -> Self {
        Self { there, has_color, frames: 0 }
    }

    /// Whether there is nothing more to learn.
    pub(crate) fn knows(&self, info: &SensorInfo) -> bool {
        match &info.model {
            SensorModel::Missing(_) => !self.there,
            SensorModel::Lidar(_) => true,
            SensorModel::Camera(camera) => {
                let placed = camera.color.is_some() && info.color_missing.is_none();
                !self.has_color || placed || self.frames >= COLOR_AHEAD
            }
        }
    }

    /// Takes in an observation of the sensor.
    pub(crate) fn learn(&mut self, info: &mut SensorInfo, observation: &Observation) {
        if self.knows(info) {
            return;
        }
        self.frames += u32::from(observation.pose.is_some());
        if let (SensorModel::Missing(_), SensorData::Scan(scan)) = (&info.model, &observation.data) {
            if info.frame_id.is_empty() {
                info.frame_id.clone_from(&scan.frame_id);
            }
            info.model = SensorModel::Lidar(LidarInfo { first: scan.clone() });
        }
        let SensorData::Frame(frame) = &observation.data else { return };
        if let SensorModel::Missing(_) = info.model {
            info.frame_id.clone_from(&frame.depth.frame_id);
            if let Some(camera) = CameraInfo::of_frames([&**frame]) {
                info.model = SensorModel::Camera(camera);
            }
        }
        let SensorModel::Camera(camera) = &mut info.model else { return };
        camera.confidence |= frame.confidence.is_some();
        let placed = frame.color.is_some() && frame.color_from_depth.is_some();
        if let Some(color) = frame.color.as_ref().filter(|_| placed || camera.color.is_none()) {
            camera.color = Some(color.camera);
            camera.color_aligned = frame.color_is_aligned();
        }
        let why = || frame.color_missing.clone().unwrap_or_else(|| "they have none".into());
        info.color_missing = (!placed).then(why);
    }
}
