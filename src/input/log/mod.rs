//! RGB-D recordings as logs of messages, read as a stream: MCAP with ROS 2 (CDR), ROS 1 or Foxglove
//! (protobuf) messages, and ROS 1 bags.

mod decode;
mod file;
mod odometry;
mod poses;
mod records;
mod scans;
mod sdk;
mod topics;

use std::path::{Path, PathBuf};

use crate::base::{Error, Result};
use crate::config::Config;
use crate::input::bag::BagRecords;
use crate::input::event::{Event, Streams, TransformEvent};
pub(crate) use crate::input::log::file::LogFile;
use crate::input::log::odometry::Odometry;
pub use crate::input::log::poses::Contents;
pub(crate) use crate::input::log::poses::{LogPoses, contents};
pub(crate) use crate::input::log::records::{Record, Records};
pub use crate::input::log::scans::LogScans;
use crate::input::log::sdk::SdkStreams;
use crate::input::log::topics::{Channel, Channels, Kind, Topics};
use crate::input::mcap::McapRecords;
use crate::input::sync::Synchronizer;
use crate::input::{ReadReport, Recording};
use crate::sensor::RgbdFrame;

/// How far a file without a summary is read ahead for its channels, bytes.
const SCAN_BYTES: u64 = 256 << 20;

/// Reads an MCAP file or a ROS 1 bag; see the module and [`Recording`].
pub struct LogReader {
    path: PathBuf,
    records: Box<dyn Records + Send>,
    channels: Channels,
    topics: Topics,
    sdk: Option<SdkStreams>,
    depth_unit_m: f64,
    sync: Synchronizer,
    report: ReadReport,
    frame_count_hint: Option<u64>,
    odometry: Option<Odometry>,
    at_end: bool,
}

impl LogReader {
    /// Opens an MCAP file and chooses its topics, from the summary or, without one, from the first
    /// 256 MiB of the file.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Format`] for a file that is not MCAP or has no depth image or
    /// calibration topic; [`Error::Config`] for a configured topic that is absent or of another type.
    pub fn mcap(path: &Path, config: &Config) -> Result<Self> {
        Self::open::<McapRecords>(path, config)
    }

    /// As [`Self::mcap`], for a ROS 1 bag and its index.
    ///
    /// # Errors
    /// As [`Self::mcap`].
    pub fn bag(path: &Path, config: &Config) -> Result<Self> {
        Self::open::<BagRecords>(path, config)
    }

    fn open<R: Records + Send + 'static>(path: &Path, config: &Config) -> Result<Self> {
        let mut report = ReadReport::default();
        let mut channels = Channels::default();
        R::summary(path)?.into_iter().for_each(|record| channels.learn(record));
        if channels.is_empty() {
            scan(&mut R::open(path)?, &mut channels)?;
            report.note("the file has no summary: its topics were found by reading ahead");
        }
        let topics = Topics::choose(&channels, config, path)?;
        report.note(topics.note());
        let sdk = SdkStreams::of(&topics);
        report.notes.extend(sdk.as_ref().map(SdkStreams::note));
        let streams = Streams {
            depth: topics.depth.clone(),
            color: topics.color.clone(),
            confidence: topics.confidence.clone(),
            depth_info: topics.depth_info.clone(),
            color_info: topics.color_info.clone(),
            has_transforms: topics.odometry.is_some() || channels.has_transforms() || sdk.is_some(),
        };
        Ok(Self {
            path: path.into(),
            records: Box::new(R::open(path)?),
            depth_unit_m: config.depth_unit_m,
            sync: Synchronizer::new(config, streams)?,
            frame_count_hint: channels.messages(&topics.depth),
            odometry: topics.odometry.as_ref().map(|_| Odometry::new(config)),
            channels,
            topics,
            sdk,
            report,
            at_end: false,
        })
    }

    /// Takes in one record; `false` at the end of the file.
    fn step(&mut self) -> Result<bool> {
        let (channels, topics, sdk) = (&self.channels, &self.topics, self.sdk.as_ref());
        let wanted = |id: u32| channels.get(id).is_some_and(|channel| is_read(topics, sdk, channel));
        let record = self.records.next(&wanted)?;
        self.records.take_notes().into_iter().for_each(|note| self.report.note(note));
        match record {
            None => return Ok(false),
            Some(Record::Message { channel_id, log_time_ns, data }) => {
                self.take_message(channel_id, log_time_ns, &data);
            }
            Some(Record::Statistics { .. }) => {}
            Some(about_channels) => self.channels.learn(about_channels),
        }
        Ok(true)
    }

    fn take_message(&mut self, channel_id: u32, log_time_ns: u64, payload: &[u8]) {
        let Some(Channel { topic, kind: Some(kind), .. }) = self.channels.get(channel_id) else { return };
        let (topic, kind) = (topic.clone(), *kind);
        match self.events(&topic, kind, payload) {
            Ok(events) => events.into_iter().for_each(|event| self.sync.push(event, &mut self.report)),
            Err(error) => {
                self.report.skip(&topic, error.to_string(), log_time_ns);
                // A depth image all the same: it has a number.
                self.report.depth_images += u64::from(topic == self.topics.depth);
            }
        }
    }

    fn events(&mut self, topic: &str, kind: Kind, payload: &[u8]) -> Result<Vec<Event>> {
        let is = |chosen: &Option<String>| chosen.as_deref() == Some(topic);
        let frame_id = self.sdk.as_ref().and_then(|sdk| sdk.frame_id(topic));
        if topic == self.topics.depth {
            return Ok(vec![Event::Depth(decode::image(kind, frame_id, payload)?)]);
        }
        if is(&self.topics.color) {
            return Ok(vec![Event::Color(decode::image(kind, frame_id, payload)?)]);
        }
        if is(&self.topics.confidence) {
            return Ok(vec![Event::Confidence(decode::image(kind, frame_id, payload)?)]);
        }
        if kind.is_calibration() {
            return Ok(vec![decode::calibration(kind, topic, frame_id, payload)?]);
        }
        let transforms = self.transforms(topic, kind, payload)?;
        Ok(transforms
            .into_iter()
            .map(|transform| Event::Transform { topic: topic.into(), transform })
            .collect())
    }

    fn transforms(&mut self, topic: &str, kind: Kind, payload: &[u8]) -> Result<Vec<TransformEvent>> {
        if self.topics.odometry.as_deref() == Some(topic) {
            let transform = decode::odometry(kind, payload)?;
            let odometry = self.odometry.as_mut();
            return Ok(odometry.map_or_else(Vec::new, |o| o.take(transform, &mut self.report)));
        }
        match (kind, &mut self.sdk) {
            (Kind::RosTransform(wire), Some(sdk)) => {
                let stream_from_reference = decode::transform(wire, payload)?;
                Ok(sdk.transform(topic, stream_from_reference).into_iter().collect())
            }
            (Kind::RosFloat(wire), _) => {
                self.check_depth_unit(wire.decode("std_msgs/Float32", payload)?);
                Ok(Vec::new())
            }
            _ => {
                let mut transforms = decode::transforms(kind, topic.contains("static"), payload)?;
                if let Some(odometry) = &mut self.odometry {
                    odometry.leave_out(&mut transforms);
                }
                Ok(transforms)
            }
        }
    }

    fn check_depth_unit(&mut self, recorded_m: f32) {
        #[expect(clippy::cast_possible_truncation, reason = "compared as the recording has it")]
        let configured_m = self.depth_unit_m as f32;
        if recorded_m != configured_m {
            self.report.note(format!(
                "the recording says that a count of depth is {recorded_m} m, but depth_unit_m is {configured_m} m: set it"
            ));
        }
    }

    /// An error where a recording had depth images but never a calibration for them.
    fn check_calibrated(&self) -> Result<()> {
        if self.report.depth_images == 0 || self.sync.calibrated() {
            return Ok(());
        }
        let reason = format!(
            "none of its {} depth images can be used: no usable calibration came on {}",
            self.report.depth_images,
            self.sync.info_name()
        );
        Err(Error::Format { path: self.path.clone(), reason })
    }
}

impl Recording for LogReader {
    fn next_frame(&mut self) -> Result<Option<RgbdFrame>> {
        loop {
            if let Some(frame) = self.sync.pop() {
                return Ok(Some(frame));
            }
            if self.at_end {
                return Ok(None);
            }
            if !self.step()? {
                self.at_end = true;
                self.sync.finish(&mut self.report);
                self.check_calibrated()?;
            }
        }
    }

    fn report(&self) -> &ReadReport {
        &self.report
    }

    fn frame_count_hint(&self) -> Option<u64> {
        self.frame_count_hint
    }
}

/// Whether a channel's messages are decoded.
fn is_read(topics: &Topics, sdk: Option<&SdkStreams>, channel: &Channel) -> bool {
    let Some(kind) = channel.kind else { return false };
    let topic = &channel.topic;
    let chosen =
        [Some(&topics.depth), topics.color.as_ref(), topics.confidence.as_ref(), topics.odometry.as_ref()];
    match kind {
        Kind::RosTransform(_) => sdk.is_some_and(|sdk| sdk.has_transform(topic)),
        Kind::RosFloat(_) => sdk.is_some_and(|sdk| sdk.has_depth_unit(topic)),
        _ => chosen.contains(&Some(topic)) || kind.is_transforms() || kind.is_calibration(),
    }
}

/// Finds the channels of a file without a summary.
fn scan(records: &mut impl Records, channels: &mut Channels) -> Result<()> {
    while let Some(record) = records.next(&|_| false)? {
        channels.learn(record);
        if records.offset() > SCAN_BYTES {
            break;
        }
    }
    Ok(())
}
