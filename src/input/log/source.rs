//! The observations of all sensors of a log in order of their stamps, in one pass.

use std::collections::VecDeque;

use crate::base::{Result, duration_ns};
use crate::config::{Config, SensorConfig, SensorInfo};
use crate::input::log::LogFiles;
use crate::input::log::choose::choose;
use crate::input::log::order::{MAX_READY, turn};
use crate::input::log::reading::Log;
use crate::input::log::sensor::{LogSensor, Reader};
#[cfg(feature = "ros2")]
use crate::input::log::topics::Channels;
use crate::input::report::merge;
use crate::input::source::{Given, Learner, SensorReport, Source, SourceReport};
use crate::sensor::{Observation, SensorModel};

/// How far stamps are read ahead for a sensor of which nothing has come, nanoseconds.
const AHEAD_NS: u64 = 10_000_000_000;

/// Most observations kept while reading ahead.
const MAX_AHEAD: usize = MAX_READY;

/// What is counted of a sensor as its observations are given.
#[derive(Debug, Clone, Copy, Default)]
struct Turns {
    given: Given,
    late: u64,
    /// Jumps and stamp of the newest given.
    newest: Option<(u32, u64)>,
}

/// See the module.
pub(crate) struct LogSource {
    /// `None`: messages are pushed.
    files: Option<LogFiles>,
    config: Config,
    log: Log,
    infos: Vec<SensorInfo>,
    learners: Vec<Learner>,
    turns: Vec<Turns>,
    ahead: VecDeque<Observation>,
    window_ns: u64,
}

impl LogSource {
    /// Opens a recording and reads ahead until its sensors are known: the first scan of a lidar, of a
    /// camera the first 8 depth images or as many as it takes to the first with colour, at most 10 s of stamps.
    ///
    /// # Errors
    /// [`crate::Error::File`]; [`crate::Error::Format`] for a file that is no log or has no sensor that can be read;
    /// [`crate::Error::Config`] for a configured topic that is absent or of another type.
    pub(crate) fn open(files: LogFiles, config: &Config) -> Result<Self> {
        let mut source = Self::at_start(files, config)?;
        source.look_ahead()?;
        if config.sensors.is_empty() {
            source.leave_out_missing();
        }
        Ok(source)
    }

    fn at_start(files: LogFiles, config: &Config) -> Result<Self> {
        let mut configs = Vec::new();
        let log = Log::open(files.clone(), |channels, report| {
            let chosen = choose(channels, config, files.path(), report)?;
            configs = chosen.configs;
            Ok((chosen.motion, chosen.sensors))
        })?;
        Ok(Self { files: Some(files), ..Self::of_log(log, configs, config) })
    }

    fn of_log(log: Log, configs: Vec<SensorConfig>, config: &Config) -> Self {
        Self {
            files: None,
            config: config.clone(),
            learners: configs.iter().zip(&log.sensors).map(learner).collect(),
            infos: configs.into_iter().map(SensorInfo::missing).collect(),
            turns: vec![Turns::default(); log.sensors.len()],
            log,
            ahead: VecDeque::new(),
            window_ns: duration_ns(config.order_window_s),
        }
    }

    /// Of messages that are pushed as they come; `name` stands for the log in messages to the user. Observations wait for
    /// earlier ones of other sensors only where these are known to wait.
    ///
    /// # Errors
    /// As [`Self::open`].
    #[cfg(feature = "ros2")]
    pub(super) fn live(name: &str, channels: Channels, config: &Config) -> Result<Self> {
        let mut configs = Vec::new();
        let log = Log::live(name, channels, |channels, report| {
            let chosen = choose(channels, config, name.as_ref(), report)?;
            configs = chosen.configs;
            Ok((chosen.motion, chosen.sensors))
        })?;
        Ok(Self { window_ns: 0, ..Self::of_log(log, configs, config) })
    }

    /// The log behind it.
    #[cfg(feature = "ros2")]
    pub(super) fn log(&mut self) -> &mut Log {
        &mut self.log
    }

    /// The next observation whose turn it is, with the number of its sensor's jumps before it; reads nothing.
    #[cfg(feature = "ros2")]
    pub(super) fn poll(&mut self) -> Option<(u32, Observation)> {
        let at = turn(&self.log.sensors, self.window_ns, false)?;
        let (jumps, observation) = self.log.sensors[at].ready.pop_front()?;
        self.count(at, jumps, &observation);
        let observation = Observation { sensor: at, ..observation };
        self.learn(&observation);
        Some((jumps, observation))
    }

    /// Whether the sensors are known as well as can be.
    #[cfg(feature = "ros2")]
    pub(super) fn knows_all(&self) -> bool {
        !self.is_ahead_needed()
    }

    /// Leaves out what was found by type and gave nothing, where something else did; which sensors these were.
    #[cfg(feature = "ros2")]
    pub(super) fn leave_out_found(&mut self) -> Vec<usize> {
        let is_missing = |info: &SensorInfo| matches!(info.model, SensorModel::Missing(_));
        let missing = self.infos.iter().enumerate().filter(|(_, info)| is_missing(info)).map(|(at, _)| at);
        let missing: Vec<usize> = missing.collect();
        if !self.config.sensors.is_empty() || missing.len() == self.infos.len() {
            return Vec::new();
        }
        self.leave_out_missing();
        missing
    }

    /// Which sensors nobody publishes.
    #[cfg(feature = "ros2")]
    pub(super) fn absent(&self) -> impl Iterator<Item = &str> {
        let absent = self.log.sensors.iter().filter(|sensor| matches!(sensor.reader, Reader::Absent));
        absent.map(|sensor| sensor.name.as_str())
    }

    fn look_ahead(&mut self) -> Result<()> {
        while self.is_ahead_needed() {
            let Some(observation) = self.read()? else { return Ok(()) };
            self.learn(&observation);
            self.ahead.push_back(observation);
            if self.ahead.len() == MAX_AHEAD && self.is_ahead_needed() {
                return self.look_further();
            }
        }
        Ok(())
    }

    /// Looks on in a second reading of the file that keeps nothing, as a sensor that is late or missing would have more
    /// kept than memory is bounded to.
    fn look_further(&mut self) -> Result<()> {
        let Some(files) = self.files.clone() else { return Ok(()) };
        let mut second = Self::at_start(files, &self.config)?;
        while second.is_ahead_needed() {
            let Some(observation) = second.read()? else { break };
            second.learn(&observation);
        }
        self.infos = second.infos;
        Ok(())
    }

    fn is_ahead_needed(&self) -> bool {
        let known = self.learners.iter().zip(&self.infos).all(|(learner, info)| learner.knows(info));
        !known && self.log.sensors.iter().all(|sensor| sensor.track.span_ns() <= AHEAD_NS)
    }

    fn learn(&mut self, observation: &Observation) {
        let at = observation.sensor;
        self.learners[at].learn(&mut self.infos[at], observation);
    }

    /// Leaves out what was found by type and gave nothing, where something else did.
    fn leave_out_missing(&mut self) {
        let is_missing = |info: &SensorInfo| matches!(info.model, SensorModel::Missing(_));
        if self.infos.iter().all(is_missing) {
            return;
        }
        while let Some(at) = self.infos.iter().position(is_missing) {
            let (info, sensor) = (self.infos.remove(at), self.log.sensors.remove(at));
            self.learners.remove(at);
            self.turns.remove(at);
            sensor.report().into_iter().for_each(|report| merge(&mut self.log.report, report));
            self.log.report.note(format!("the {} is left out: nothing of it can be used", info.name));
            for kept in self.ahead.iter_mut().filter(|kept| kept.sensor > at) {
                kept.sensor -= 1;
            }
        }
    }

    /// The next observation of the log.
    fn read(&mut self) -> Result<Option<Observation>> {
        loop {
            if let Some(at) = turn(&self.log.sensors, self.window_ns, self.log.at_end)
                && let Some((jumps, observation)) = self.log.sensors[at].ready.pop_front()
            {
                self.count(at, jumps, &observation);
                return Ok(Some(Observation { sensor: at, ..observation }));
            }
            if self.log.at_end {
                return Ok(None);
            }
            self.log.step()?;
            self.log.settle();
        }
    }

    fn count(&mut self, at: usize, jumps: u32, observation: &Observation) {
        let moment = (jumps, observation.stamp_ns());
        let after = |turns: &Turns| turns.newest.is_some_and(|newest| newest.0 == jumps && newest > moment);
        let others = self.turns.iter().enumerate().filter(|&(other, _)| other != at);
        let late = others.map(|(_, turns)| turns).any(after);
        let turns = &mut self.turns[at];
        turns.late += u64::from(late);
        turns.given.count(observation);
        turns.newest = turns.newest.max(Some(moment));
    }
}

/// What is to be learnt of a sensor.
fn learner((_, sensor): (&SensorConfig, &LogSensor)) -> Learner {
    match &sensor.reader {
        Reader::Camera(camera) => Learner::new(true, camera.has_color()),
        Reader::Lidar(_) => Learner::new(true, false),
        Reader::Absent => Learner::new(false, false),
    }
}

fn sensor_report(sensor: &LogSensor, turns: &Turns) -> SensorReport {
    let report = SensorReport {
        late: turns.late,
        jumps: u64::from(sensor.track.jumps),
        ..SensorReport::new(&sensor.name, turns.given)
    };
    match &sensor.reader {
        Reader::Camera(camera) => SensorReport {
            seen: camera.report.depth_images,
            unusable: camera.report.depth_images - camera.frames - camera.sync.waiting(),
            ..report
        },
        Reader::Lidar(lidar) => SensorReport {
            seen: lidar.report.scans + lidar.unusable,
            points: lidar.report.points,
            dropped: lidar.report.dropped,
            unusable: lidar.unusable,
            ..report
        },
        Reader::Absent => report,
    }
}

impl Source for LogSource {
    fn sensors(&self) -> &[SensorInfo] {
        &self.infos
    }

    fn next(&mut self) -> Result<Option<Observation>> {
        match self.ahead.pop_front() {
            Some(observation) => Ok(Some(observation)),
            None => self.read(),
        }
    }

    fn report(&self) -> SourceReport {
        let sensors = self.log.sensors.iter().zip(&self.turns);
        let mut read = self.log.whole_report();
        self.log.explain_poses().for_each(|told| read.tell_frames(told));
        SourceReport { read, sensors: sensors.map(|(sensor, turns)| sensor_report(sensor, turns)).collect() }
    }

    fn uses(&self) -> Vec<(String, String)> {
        self.log.uses()
    }

    fn count_hint(&self) -> Option<u64> {
        let hints = self.log.sensors.iter().filter_map(|sensor| match &sensor.reader {
            Reader::Camera(camera) => self.log.channels.messages(camera.depth_topic()),
            Reader::Lidar(lidar) => self.log.channels.messages(&lidar.topic),
            Reader::Absent => None,
        });
        hints.reduce(|a, b| a + b)
    }
}
