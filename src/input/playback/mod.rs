//! A recording as ROS 2 messages, one after the other: those of a log as they are, or as ROS 2 has them; those of other
//! recordings made of their images and scans.

mod convert;
mod log;
mod made;

use std::path::Path;

use crate::base::Result;
use crate::config::Config;
use crate::input::log::is_image_of_sdk;
use crate::input::open::log_files;
use crate::input::playback::log::LogMessages;
use crate::input::playback::made::MadeMessages;
use crate::input::{ReadReport, Skipped, open_source};

/// What a topic's messages are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Sensor data: each is worth little, and replaced by the next.
    Sensor,
    /// What holds until it is replaced (`/tf_static`).
    Fixed,
    /// Anything else.
    Stream,
}

/// A topic that is played.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlayedTopic {
    /// Full name, with a leading slash.
    pub name: String,
    /// As in `sensor_msgs/msg/Image`.
    pub type_name: String,
    /// What its messages are for.
    pub purpose: Purpose,
}

impl PlayedTopic {
    fn new(name: &str, type_name: &str) -> Self {
        let is_static = type_name == "tf2_msgs/msg/TFMessage" && name.contains("static");
        let sensor =
            ["sensor_msgs/", "velodyne_msgs/", "livox_"].iter().any(|start| type_name.starts_with(start));
        let purpose = match (is_static, sensor) {
            (true, _) => Purpose::Fixed,
            (false, true) => Purpose::Sensor,
            (false, false) => Purpose::Stream,
        };
        Self { name: format!("/{}", name.trim_start_matches('/')), type_name: type_name.into(), purpose }
    }
}

/// A message and when it comes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Played {
    /// Its topic, as [`Playback::topics`] counts them.
    pub topic: usize,
    /// When the recorder received it, nanoseconds; of images and scans without a recorder their stamps.
    pub at_ns: u64,
    /// Encapsulated little-endian CDR.
    pub payload: Vec<u8>,
}

/// What the messages come from.
enum From {
    Log(Box<LogMessages>),
    Made(Box<MadeMessages>),
}

/// See the module.
pub struct Playback(From);

impl Playback {
    /// Opens any recording that [`open_source`] opens; a log also where it holds no sensor that limpid reads. One of the RealSense
    /// SDK's layout, which no ROS node knows, is played as images, calibrations and transforms made of it.
    ///
    /// # Errors
    /// What [`open_source`] returns.
    pub fn open(path: &Path, config: &Config) -> Result<Self> {
        let made = || -> Result<Self> {
            Ok(Self(From::Made(Box::new(MadeMessages::new(open_source(path, config)?)))))
        };
        let Some(files) = log_files(path, config)? else { return made() };
        let log = LogMessages::open(files)?;
        if log.topics.iter().any(|topic| is_image_of_sdk(&topic.name)) {
            return made();
        }
        Ok(Self(From::Log(Box::new(log))))
    }

    /// The topics.
    pub fn topics(&self) -> &[PlayedTopic] {
        match &self.0 {
            From::Log(log) => &log.topics,
            From::Made(made) => &made.topics,
        }
    }

    /// The next message, or `None` at the end.
    ///
    /// # Errors
    /// Only what ends the recording; single bad messages are counted in the report.
    pub fn next_message(&mut self) -> Result<Option<Played>> {
        match &mut self.0 {
            From::Log(log) => log.next_message(),
            From::Made(made) => made.next_message(),
        }
    }

    /// What was left out so far, and notes.
    pub fn report(&self) -> ReadReport {
        match &self.0 {
            From::Log(log) => log.report.clone(),
            From::Made(made) => made.report(),
        }
    }

    /// Topics that are not played, with the reason.
    pub fn unplayed(&self) -> &[Skipped] {
        match &self.0 {
            From::Log(log) => &log.unplayed,
            From::Made(_) => &[],
        }
    }
}
