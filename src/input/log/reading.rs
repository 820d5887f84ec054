//! One pass over a log: what it says of any number of cameras and lidars, and of the robot's motion, which they share.

use std::collections::BTreeMap;
use std::path::PathBuf;

use crate::base::{Error, Result};
use crate::input::ReadReport;
use crate::input::event::{Event, TransformEvent};
use crate::input::frames::FrameTree;
use crate::input::log::decode::{self, CalibrationMessage};
use crate::input::log::inventory::Counted;
use crate::input::log::motion::Motion;
use crate::input::log::sensor::{LogSensor, Reader};
use crate::input::log::splits::{Splits, Survey};
use crate::input::log::topics::{Channel, Channels, Kind};
use crate::input::log::{LogFiles, Record};
use crate::input::points::ScanReport;
use crate::input::report::merge;
use crate::input::zstd_frame;
use crate::sensor::Observation;

/// See the module.
pub(crate) struct Log {
    pub(super) path: PathBuf,
    /// `None`: messages are pushed.
    records: Option<Splits>,
    pub(super) channels: Channels,
    motion: Motion,
    pub(super) sensors: Vec<LogSensor>,
    /// Newest log time, nanoseconds.
    log_time_ns: u64,
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

/// The error for a recording that lacks something, with the damage that may be the cause.
fn with_damage(error: Error, damage: &str) -> Error {
    match error {
        Error::Format { path, reason } if !damage.is_empty() => {
            Error::Format { path, reason: format!("{reason}; {damage}") }
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
            choose(&channels, &mut report).map_err(|error| with_damage(error, &survey.damage.join("; ")))?;
        let path = files.path().into();
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
        records.take_notes().into_iter().for_each(|note| self.report.note(note));
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
            records.take_notes().into_iter().for_each(|note| self.report.note(note));
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
                        return Err(Error::Format { path: self.path.clone(), reason });
                    }
                    camera.report.note(format!("`{}`: {reason}", sensor.name));
                }
                Reader::Absent => {}
            }
        }
        Ok(())
    }

    /// Messages that rosbag2 packed one by one are unpacked.
    fn take_message(&mut self, channel_id: u32, log_time_ns: u64, payload: &[u8]) {
        if !zstd_frame::is_packed(payload) {
            return self.take_unpacked(channel_id, log_time_ns, payload);
        }
        match zstd_frame::unpack(payload) {
            Ok(unpacked) => self.take_unpacked(channel_id, log_time_ns, &unpacked),
            Err(error) => {
                let topic = self.channels.get(channel_id).map_or("", |channel| &channel.topic);
                self.report.skip(topic, error.to_string(), log_time_ns);
            }
        }
    }

    fn take_unpacked(&mut self, channel_id: u32, log_time_ns: u64, payload: &[u8]) {
        let Some(channel) = self.channels.get(channel_id) else { return };
        let Channel { topic, kind: Some(kind), .. } = channel else { return };
        let (channel, topic, kind) = (channel.clone(), topic.clone(), *kind);
        self.log_time_ns = self.log_time_ns.max(log_time_ns);
        let taken = if kind.is_calibration() {
            self.take_calibration(&topic, kind, payload)
        } else if self.motion.reads(&channel) {
            let transforms = self.motion.take(&topic, kind, log_time_ns, payload, &mut self.report);
            transforms.map(|transforms| transforms.iter().for_each(|t| self.take_transform(&topic, t)))
        } else {
            self.take_data(&channel, kind, log_time_ns, payload)
        };
        if let Err(error) = taken {
            self.report.skip(&topic, error.to_string(), log_time_ns);
        }
    }

    fn take_calibration(&mut self, topic: &str, kind: Kind, payload: &[u8]) -> Result<()> {
        let CalibrationMessage { stamp_ns, frame_id, calibration } = decode::calibration(kind, payload)?;
        let calibration = calibration.map_err(|error| {
            let reason = error.to_string();
            self.report.skip(topic, &*reason, stamp_ns);
            reason
        });
        let Self { sensors, motion, .. } = self;
        for sensor in sensors {
            let Reader::Camera(camera) = &mut sensor.reader else { continue };
            let frame_id = camera.frame_id(topic).unwrap_or(&frame_id).to_owned();
            let event =
                Event::Calibration { topic: topic.into(), frame_id, calibration: calibration.clone() };
            camera.sync.push(event, &motion.poses, &mut camera.report);
        }
        Ok(())
    }

    fn take_transform(&mut self, topic: &str, transform: &TransformEvent) {
        if self.motion.poses.jumps_back(transform) {
            self.restart(
                "transform stamps jumped back by more than a second: pairing and transforms start over there",
            );
        }
        self.motion.poses.take(topic, transform, &mut self.report);
    }

    /// The transforms start over, and with them what was seen before they did.
    fn restart(&mut self, note: &str) {
        for sensor in &mut self.sensors {
            sensor.restart_with_transforms(&self.motion);
        }
        self.motion.poses.tree.clear_samples();
        self.report.note(note);
    }

    fn take_data(&mut self, channel: &Channel, kind: Kind, log_time_ns: u64, payload: &[u8]) -> Result<()> {
        for at in 0..self.sensors.len() {
            if !self.sensors[at].reads(channel) {
                continue;
            }
            match &mut self.sensors[at].reader {
                Reader::Lidar(lidar) => lidar.take(kind, log_time_ns, payload),
                Reader::Camera(camera) if matches!(kind, Kind::RosTransform(_) | Kind::RosFloat(_)) => {
                    let transform = camera.sdk_transform(&channel.topic, kind, payload)?;
                    if let Some(transform) = transform {
                        self.take_transform(&channel.topic, &transform);
                    }
                }
                Reader::Camera(camera) => {
                    if let Some(event) = camera.event(&channel.topic, kind, log_time_ns, payload) {
                        self.take_event(at, event, log_time_ns);
                    }
                }
                Reader::Absent => {}
            }
        }
        Ok(())
    }

    fn take_event(&mut self, at: usize, event: Event, log_time_ns: u64) {
        let alone = self.sensors.len() == 1;
        let LogSensor { name, reader, ready, track } = &mut self.sensors[at];
        let Reader::Camera(camera) = reader else { return };
        if let Some(what) = camera.restart_at(&event, &self.motion) {
            while let Some(observation) = camera.pop(&self.motion) {
                ready.push_back((track.jumps, observation));
            }
            let scope = if alone { "pairing and transforms start" } else { "its pairing starts" };
            camera
                .report
                .note(format!("`{name}`: {what} jumped back by more than a second: {scope} over there"));
            // The transforms serve others whose stamps may not have jumped.
            if alone {
                self.motion.poses.tree.clear_samples();
            }
        }
        let seen_ns = if let Event::Depth(image) = &event { Some(image.stamp_ns) } else { None };
        if let Some(stamp_ns) = seen_ns {
            track.see(stamp_ns, log_time_ns);
        }
        camera.sync.push(event, &self.motion.poses, &mut camera.report);
        if seen_ns.is_some() {
            self.compare_clocks(at);
        }
    }

    /// Has scans that are decoded wait for their poses.
    fn take_scans(&mut self) {
        for at in 0..self.sensors.len() {
            let mut seen = false;
            let LogSensor { name, reader, track, .. } = &mut self.sensors[at];
            let Reader::Lidar(lidar) = reader else { continue };
            while let Some(scan) = lidar.next_scan() {
                let jumped = track.see(scan.stamp_ns, self.log_time_ns);
                if jumped {
                    let note = format!("`{name}`: stamps of scans jumped back by more than a second");
                    lidar.report.read.note(note);
                }
                lidar.wait(scan, jumped);
                seen = true;
            }
            if seen {
                self.compare_clocks(at);
            }
        }
    }

    /// Tells of clocks that differ from that of a sensor.
    fn compare_clocks(&mut self, at: usize) {
        let this = &self.sensors[at];
        for other in self.sensors.iter().filter(|other| other.name != this.name) {
            let Some(ahead_s) = this.track.ahead_of_s(&other.track) else { continue };
            let (first, last, ahead_s) = if ahead_s > 0.0 {
                (&this.name, &other.name, ahead_s)
            } else {
                (&other.name, &this.name, -ahead_s)
            };
            self.report.note_once(
                &format!("clocks differ: stamps of `{first}` are ahead of those of `{last}`"),
                &format!(" by {ahead_s:.1} s when they are read"),
            );
        }
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
