//! Observations of all sensors of a recording, one after the other.

use std::path::Path;

use super::points::ScanReport;
use super::{PosedScans, ReadReport, Recording, contents, open};
use crate::base::Result;
use crate::config::{Config, SensorKind};
use crate::mapper::SensorInfo;
use crate::sensor::{CameraInfo, Dropped, Observation};

/// What was met of one sensor.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SensorReport {
    /// Its name.
    pub name: String,
    /// Depth images, or scans, seen.
    pub seen: u64,
    /// Points left out of its scans, by reason.
    pub dropped: Dropped,
}

/// What a source met on its way, complete once `next` has returned `None`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SourceReport {
    /// Messages passed over, and notes.
    pub read: ReadReport,
    /// Of each sensor, as they are counted.
    pub sensors: Vec<SensorReport>,
}

/// A stream of observations; never holds more than a bounded window in memory.
pub trait Source {
    /// The sensors, known before the first observation; [`Observation::sensor`] counts them.
    fn sensors(&self) -> &[SensorInfo];

    /// The next observation, or `None` at the end.
    ///
    /// # Errors
    /// Only what ends the recording; single bad messages are counted in the report.
    fn next(&mut self) -> Result<Option<Observation>>;

    /// What was met so far.
    fn report(&self) -> SourceReport;

    /// How many observations there are, where that is known.
    fn count_hint(&self) -> Option<u64>;
}

/// Depth images read ahead to find the first with colour, whose calibration the passes are built for.
const LOOKAHEAD: usize = 8;

/// Opens the sensors of a recording.
///
/// # Errors
/// What [`open`] and [`PosedScans::open`] return.
pub fn open_source(path: &Path, config: &Config, only: Option<SensorKind>) -> Result<Box<dyn Source>> {
    let found = contents(path, config)?;
    let lidar = only.map_or(found.lidar && !found.camera, |kind| kind == SensorKind::Lidar);
    if lidar {
        return Ok(Box::new(LidarSource::new(PosedScans::open(path, config)?, config)?));
    }
    Ok(Box::new(CameraSource::new(open(path, config)?, config)?))
}

/// A camera alone.
pub struct CameraSource {
    recording: Box<dyn Recording>,
    map_frame: String,
    ahead: std::collections::VecDeque<crate::sensor::RgbdFrame>,
    sensors: Vec<SensorInfo>,
}

impl CameraSource {
    /// Of a recording's depth images.
    ///
    /// # Errors
    /// Those of the recording.
    pub fn new(mut recording: Box<dyn Recording>, config: &Config) -> Result<Self> {
        let mut ahead = std::collections::VecDeque::new();
        while ahead.len() < LOOKAHEAD
            && !ahead
                .iter()
                .any(|frame: &crate::sensor::RgbdFrame| frame.color.is_some() && frame.pose.is_some())
        {
            let Some(frame) = recording.next_frame()? else { break };
            ahead.push_back(frame);
        }
        let posed = || ahead.iter().filter(|frame| frame.pose.is_some());
        let info = CameraInfo::of_frames(posed()).or_else(|| CameraInfo::of_frames(&ahead));
        let info = info.map(|info| SensorInfo::camera(config, info));
        Ok(Self {
            recording,
            map_frame: config.map_frame.clone(),
            sensors: info.into_iter().collect(),
            ahead,
        })
    }
}

impl Source for CameraSource {
    fn sensors(&self) -> &[SensorInfo] {
        &self.sensors
    }

    fn next(&mut self) -> Result<Option<Observation>> {
        let frame = match self.ahead.pop_front() {
            Some(frame) => Some(frame),
            None => self.recording.next_frame()?,
        };
        Ok(frame.map(|frame| Observation::of_frame(0, &self.map_frame, frame)))
    }

    fn report(&self) -> SourceReport {
        let read = self.recording.report().clone();
        let sensor =
            SensorReport { name: "camera".into(), seen: read.depth_images, ..SensorReport::default() };
        SourceReport { read, sensors: vec![sensor] }
    }

    fn count_hint(&self) -> Option<u64> {
        self.recording.frame_count_hint()
    }
}

/// A lidar alone.
pub struct LidarSource {
    scans: PosedScans,
    ahead: Option<Observation>,
    sensors: Vec<SensorInfo>,
}

impl LidarSource {
    /// Of a recording's scans.
    ///
    /// # Errors
    /// Those of the recording.
    pub fn new(mut scans: PosedScans, config: &Config) -> Result<Self> {
        let ahead = scans.next_observation()?;
        let info =
            ahead.as_ref().and_then(Observation::scan).map(|scan| SensorInfo::lidar(config, scan.clone()));
        Ok(Self { scans, ahead, sensors: info.into_iter().collect() })
    }
}

impl Source for LidarSource {
    fn sensors(&self) -> &[SensorInfo] {
        &self.sensors
    }

    fn next(&mut self) -> Result<Option<Observation>> {
        match self.ahead.take() {
            Some(observation) => Ok(Some(observation)),
            None => self.scans.next_observation(),
        }
    }

    fn report(&self) -> SourceReport {
        let ScanReport { scans, dropped, read, .. } = self.scans.report();
        SourceReport { read, sensors: vec![SensorReport { name: "lidar".into(), seen: scans, dropped }] }
    }

    fn count_hint(&self) -> Option<u64> {
        self.scans.scan_count_hint()
    }
}
