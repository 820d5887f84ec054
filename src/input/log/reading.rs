//! One pass over a log: what it says of any number of cameras and lidars, and of the robot's motion, which they share.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::base::{Error, Result};
use crate::input::ReadReport;
use crate::input::frames::FrameTree;
use crate::input::log::inventory::Counted;
use crate::input::log::motion::Motion;
use crate::input::log::sensor::{LogSensor, Reader};
use crate::input::log::splits::{Splits, Survey};
use crate::input::log::topics::{Channel, Channels, Kind};
use crate::input::log::{LogFiles, Record};
use crate::input::points::ScanReport;
use crate::input::report::merge;
use crate::sensor::Observation;

/// See the module.
pub(crate) struct Log {
    pub(super) path: PathBuf,
    /// `None`: messages are pushed.
    records: Option<Splits>,
    pub(super) channels: Channels,
    pub(super) motion: Motion,
    pub(super) sensors: Vec<LogSensor>,
    /// Newest log time, nanoseconds.
    pub(super) log_time_ns: u64,
    /// What is no single sensor's.
    pub(super) report: ReadReport,
    pub(super) at_end: bool,
}

/// Whether messages of a channel are read: those of the sensors and of the robot's motion, and all calibrations of cameras.
fn wants(channels: &Channels, motion: &Motion, sensors: &[LogSensor], id: u32) -> bool {
    channels.get(id).is_some_and(|channel| {
        let has_camera = || sensors.iter().any(|sensor| matches!(sensor.reader, Reader::Camera(_)));
        let is_info = channel.kind.is_some_and(Kind::is_calibration) && has_camera();
        is_info || motion.reads(channel) || sensors.iter().any(|sensor| sensor.reads(channel))
    })
}

/// The error for a recording that lacks something, after the damage that may be the cause.
fn with_damage(error: Error, damage: &[String]) -> Error {
    match error {
        Error::Format { path, reason } if !damage.is_empty() => {
            Error::Format { path, reason: format!("{}; {reason}", damage.join("; ")) }
        }
        other => other,
    }
}

impl Log {
    /// Opens a recording; `choose` says which sensors and motion are read of its channels.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Format`] for other files; what `choose` gives.
    pub(super) fn open(
        files: LogFiles,
        choose: impl FnOnce(&Channels, &mut ReadReport) -> Result<(Motion, Vec<LogSensor>)>,
    ) -> Result<Self> {
        let mut report = ReadReport::default();
        let mut survey = Survey::of(&files)?;
        let channels = std::mem::take(&mut survey.channels);
        survey.notes.drain(..).for_each(|note| report.note(note));
        let (motion, sensors) =
            choose(&channels, &mut report).map_err(|error| with_damage(error, &survey.damage))?;
        let path = files.path().into();
        report.tell_files(files.told());
        let records = Some(Splits::open(files, survey)?);
        Ok(Self { path, records, channels, motion, sensors, log_time_ns: 0, report, at_end: false })
    }

    /// A log whose messages are pushed as they come; `name` stands for its path in messages to the user.
    ///
    /// # Errors
    /// What `choose` gives.
    #[cfg(feature = "ros2")]
    pub(super) fn live(
        name: &str,
        channels: Channels,
        choose: impl FnOnce(&Channels, &mut ReadReport) -> Result<(Motion, Vec<LogSensor>)>,
    ) -> Result<Self> {
        let mut report = ReadReport::default();
        let (motion, sensors) = choose(&channels, &mut report)?;
        let path = name.into();
        Ok(Self { path, records: None, channels, motion, sensors, log_time_ns: 0, report, at_end: false })
    }

    /// Whether messages of a channel are read.
    #[cfg(feature = "ros2")]
    pub(super) fn wants(&self, id: u32) -> bool {
        wants(&self.channels, &self.motion, &self.sensors, id)
    }

    /// Whether the log says anything of the robot's motion.
    #[cfg(feature = "ros2")]
    pub(super) fn is_motion_recorded(&self) -> bool {
        self.motion.is_recorded()
    }

    /// Takes a message that came at `now_ns`, and moves on what waits for nothing any more or has waited for
    /// `patience_ns`.
    #[cfg(feature = "ros2")]
    pub(super) fn push(&mut self, channel_id: u32, now_ns: u64, payload: &[u8], patience_ns: u64) {
        self.sensors.iter_mut().for_each(|sensor| sensor.go_by_clock(now_ns, patience_ns));
        self.take_message(channel_id, now_ns, payload);
        self.settle_at(now_ns, patience_ns);
    }

    /// Moves on what waits for nothing any more or has waited for `patience_ns`, as the clock says `now_ns`.
    #[cfg(feature = "ros2")]
    pub(super) fn settle_at(&mut self, now_ns: u64, patience_ns: u64) {
        self.sensors.iter_mut().for_each(|sensor| sensor.go_by_clock(now_ns, patience_ns));
        self.log_time_ns = self.log_time_ns.max(now_ns);
        self.settle();
    }

    /// Reads on by one record, or to the end of the log.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Format`] where the one sensor is a camera none of whose images can be used.
    pub(super) fn step(&mut self) -> Result<()> {
        let (channels, sensors, motion) = (&self.channels, &self.sensors, &self.motion);
        let wanted = |id: u32| wants(channels, motion, sensors, id);
        let Some(records) = &mut self.records else { return self.end() };
        let record = records.next(&wanted)?;
        records.take_notes().into_iter().for_each(|note| self.report.tell_damage(note));
        match record {
            None => return self.end(),
            Some(Record::Message { channel_id, log_time_ns, data }) => {
                self.take_message(channel_id, log_time_ns, &data);
            }
            Some(Record::Statistics { .. }) => {}
            Some(about_channels) => {
                self.channels.learn(about_channels);
                self.motion.learn(&self.channels);
            }
        }
        Ok(())
    }

    /// Takes in transforms, and counts messages by channel (all of them with `counts_all`), until the end or until so many
    /// bytes are gone through.
    ///
    /// # Errors
    /// [`Error::File`].
    pub(super) fn skim(&mut self, counts_all: bool, most_bytes: u64) -> Result<BTreeMap<u32, Counted>> {
        let mut counted = BTreeMap::new();
        while let Some(records) = &mut self.records
            && records.offset() < most_bytes
        {
            let (channels, motion) = (&self.channels, &self.motion);
            let wanted =
                |id: u32| counts_all || channels.get(id).is_some_and(|channel| motion.reads(channel));
            let record = records.next(&wanted)?;
            records.take_notes().into_iter().for_each(|note| self.report.tell_damage(note));
            match record {
                None => {
                    self.at_end = true;
                    break;
                }
                Some(Record::Message { channel_id, log_time_ns, data }) => {
                    let channel = Counted::add(counted.get(&channel_id).copied(), log_time_ns);
                    counted.insert(channel_id, channel);
                    if self.channels.get(channel_id).is_some_and(|channel| self.motion.reads(channel)) {
                        self.take_message(channel_id, log_time_ns, &data);
                    }
                }
                Some(Record::Statistics { .. }) => {}
                Some(about_channels) => {
                    self.channels.learn(about_channels);
                    self.motion.learn(&self.channels);
                }
            }
        }
        Ok(counted)
    }

    /// The frames that transforms were seen of.
    pub(super) fn frames(&self) -> &FrameTree {
        &self.motion.poses.frames
    }

    /// What each topic that is read is used for.
    pub(super) fn uses(&self) -> Vec<(String, String)> {
        let of_channel = |channel: &Channel| {
            let of_sensor = |sensor: &LogSensor| Some(format!("{}: {}", sensor.name, sensor.role(channel)?));
            let sensors = self.sensors.iter().filter_map(of_sensor);
            let poses = self.motion.reads(channel).then(|| self.motion.role(channel).to_owned());
            sensors.chain(poses).map(|role| (channel.topic.clone(), role)).collect::<Vec<_>>()
        };
        self.channels.all().flat_map(|(_, channel)| of_channel(channel)).collect()
    }

    /// Moves on what waits for nothing any more.
    pub(super) fn settle(&mut self) {
        self.take_scans();
        let log_now_ns = (!self.at_end).then_some(self.log_time_ns);
        for sensor in &mut self.sensors {
            sensor.settle(&self.motion, log_now_ns);
        }
    }

    fn end(&mut self) -> Result<()> {
        self.at_end = true;
        let alone = self.sensors.len() == 1;
        for sensor in &mut self.sensors {
            match &mut sensor.reader {
                Reader::Lidar(lidar) => lidar.finish(),
                Reader::Camera(camera) => {
                    let Some(reason) = camera.uncalibrated() else { continue };
                    if alone {
                        camera.sync.finish(&self.motion.poses, &mut camera.report);
                        let error = Error::Format { path: self.path.clone(), reason };
                        return Err(with_damage(error, &self.report.damage));
                    }
                    camera.report.note(format!("`{}`: {reason}", sensor.name));
                }
                Reader::Absent => {}
            }
        }
        Ok(())
    }

    /// The next observation of a log with one sensor.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub(crate) fn next_of_one(&mut self) -> Result<Option<Observation>> {
        loop {
            let ready = self.sensors.first_mut().and_then(|sensor| sensor.ready.pop_front());
            if ready.is_some() || self.at_end {
                return Ok(ready.map(|(_, observation)| observation));
            }
            self.step()?;
            self.settle();
        }
    }

    /// Why sensors have no poses, as far as the log was read.
    pub(super) fn explain_poses(&self) -> impl Iterator<Item = String> {
        self.sensors.iter().filter_map(|sensor| {
            let (posing, kind) = sensor.posing()?;
            self.motion.explain(posing, kind)
        })
    }

    /// How many scans a log whose one sensor is a lidar says it holds.
    pub(crate) fn scan_count_hint(&self) -> Option<u64> {
        match self.sensors.first().map(|sensor| &sensor.reader) {
            Some(Reader::Lidar(lidar)) => self.channels.messages(&lidar.topic),
            _ => None,
        }
    }

    /// What was met so far of a log whose one sensor is a lidar.
    pub(crate) fn scan_report(&self) -> ScanReport {
        let read = self.whole_report();
        match self.sensors.first().map(|sensor| &sensor.reader) {
            Some(Reader::Lidar(lidar)) => ScanReport { read, ..lidar.report.clone() },
            _ => ScanReport { read, ..ScanReport::default() },
        }
    }

    /// What was met so far; at the end of the log also why sensors have no poses.
    pub(crate) fn whole_report(&self) -> ReadReport {
        let mut whole = self.report.clone();
        if self.at_end {
            self.explain_poses().for_each(|told| whole.tell_frames(told));
        }
        for report in self.sensors.iter().filter_map(LogSensor::report) {
            whole.depth_images += report.depth_images;
            merge(&mut whole, report);
        }
        whole
    }
}
