//! Recordings of one sensor as sources.

use std::collections::VecDeque;
use std::path::Path;

use crate::base::{Error, Result};
use crate::config::{Config, SensorConfig, SensorInfo, SensorKind};
use crate::input::source::{Given, Learner, SensorReport, Source, SourceReport};
use crate::input::{PosedScans, Recording};
use crate::sensor::Observation;

/// Which of the sensors of a recording the observations are of: the first of their kind, the others are missing.
struct Listed {
    at: usize,
    infos: Vec<SensorInfo>,
    learner: Learner,
    given: Given,
}

impl Listed {
    fn new(kind: SensorKind, config: &Config, path: &Path) -> Result<Self> {
        let found = SensorConfig::found(kind, config);
        let configs = if config.sensors.is_empty() { vec![found] } else { config.sensors.clone() };
        let at = configs.iter().position(|sensor| sensor.kind == kind).ok_or_else(|| {
            let reason = format!("names no {}, but {} is of one", kind.name(), path.display());
            Error::Config { key: "sensors".into(), reason }
        })?;
        Ok(Self {
            at,
            infos: configs.into_iter().map(SensorInfo::missing).collect(),
            learner: Learner::new(true, kind == SensorKind::Camera),
            given: Given::default(),
        })
    }

    fn config(&self) -> &Config {
        &self.infos[self.at].config
    }

    /// The first observations, as many as it takes to know the sensor.
    fn look_ahead(
        &mut self,
        mut read: impl FnMut() -> Result<Option<Observation>>,
    ) -> Result<VecDeque<Observation>> {
        let mut ahead = VecDeque::new();
        while ahead.len() < 64 && !self.learner.knows(&self.infos[self.at]) {
            let Some(observation) = read()? else { break };
            self.learner.learn(&mut self.infos[self.at], &observation);
            ahead.push_back(observation);
        }
        Ok(ahead)
    }

    fn reports(&self, own: SensorReport) -> Vec<SensorReport> {
        let mut reports: Vec<SensorReport> =
            self.infos.iter().map(|info| SensorReport::new(&info.name, Given::default())).collect();
        reports[self.at] = own;
        reports
    }

    fn own_report(&self) -> SensorReport {
        SensorReport::new(&self.infos[self.at].name, self.given)
    }
}

/// The frames of a camera.
pub(crate) struct CameraSource {
    recording: Box<dyn Recording>,
    listed: Listed,
    ahead: VecDeque<Observation>,
}

impl CameraSource {
    /// # Errors
    /// What `open` and the first frames return; [`Error::Config`] where the configuration names no camera.
    pub(crate) fn open(
        path: &Path,
        config: &Config,
        open: impl FnOnce(&Path, &Config) -> Result<Box<dyn Recording>>,
    ) -> Result<Self> {
        let mut listed = Listed::new(SensorKind::Camera, config, path)?;
        let mut recording = open(path, listed.config())?;
        let (at, map_frame) = (listed.at, config.map_frame.clone());
        let ahead = listed.look_ahead(|| frame(recording.as_mut(), at, &map_frame))?;
        Ok(Self { recording, listed, ahead })
    }
}

fn frame(recording: &mut dyn Recording, sensor: usize, map_frame: &str) -> Result<Option<Observation>> {
    let frame = recording.next_frame()?;
    Ok(frame.map(|frame| Observation::of_frame(sensor, map_frame, frame)))
}

impl Source for CameraSource {
    fn sensors(&self) -> &[SensorInfo] {
        &self.listed.infos
    }

    fn next(&mut self) -> Result<Option<Observation>> {
        let next = match self.ahead.pop_front() {
            Some(observation) => Some(observation),
            None => frame(self.recording.as_mut(), self.listed.at, &self.listed.config().map_frame)?,
        };
        next.iter().for_each(|observation| self.listed.given.count(observation));
        Ok(next)
    }

    fn report(&self) -> SourceReport {
        let read = self.recording.report().clone();
        let own = self.listed.own_report();
        let waiting = self.ahead.len() as u64;
        let unusable = read.depth_images - own.given - waiting;
        let own = SensorReport { seen: read.depth_images, unusable, ..own };
        SourceReport { sensors: self.listed.reports(own), read }
    }

    fn count_hint(&self) -> Option<u64> {
        self.recording.frame_count_hint()
    }
}

/// The scans of a lidar.
pub(crate) struct LidarSource {
    scans: PosedScans,
    listed: Listed,
    ahead: VecDeque<Observation>,
}

impl LidarSource {
    /// # Errors
    /// What [`PosedScans::open`] and the first scan return; [`Error::Config`] where the configuration names no lidar.
    pub(crate) fn open(path: &Path, config: &Config) -> Result<Self> {
        let mut listed = Listed::new(SensorKind::Lidar, config, path)?;
        let mut scans = PosedScans::open(path, listed.config())?;
        let ahead = listed.look_ahead(|| scans.next_observation())?;
        Ok(Self { scans, listed, ahead })
    }
}

impl Source for LidarSource {
    fn sensors(&self) -> &[SensorInfo] {
        &self.listed.infos
    }

    fn next(&mut self) -> Result<Option<Observation>> {
        let next = match self.ahead.pop_front() {
            Some(observation) => Some(observation),
            None => self.scans.next_observation()?,
        };
        next.iter().for_each(|observation| self.listed.given.count(observation));
        Ok(next.map(|observation| Observation { sensor: self.listed.at, ..observation }))
    }

    fn report(&self) -> SourceReport {
        let report = self.scans.report();
        let own = SensorReport {
            seen: report.scans,
            points: report.points,
            dropped: report.dropped,
            ..self.listed.own_report()
        };
        SourceReport { sensors: self.listed.reports(own), read: report.read }
    }

    fn count_hint(&self) -> Option<u64> {
        self.scans.scan_count_hint()
    }
}
