//! The frames of one camera of a log.

use std::path::Path;

use crate::base::Result;
use crate::config::Config;
use crate::input::log::camera::LogCamera;
use crate::input::log::motion::Motion;
use crate::input::log::reading::Log;
use crate::input::log::sensor::{LogSensor, Reader};
use crate::input::log::topics::Topics;
use crate::input::log::{Format, LogFiles};
use crate::input::{ReadReport, Recording};
use crate::sensor::{RgbdFrame, SensorData};

/// Reads a recording of messages; see [`Recording`].
pub struct LogReader {
    log: Log,
    report: ReadReport,
    frame_count_hint: Option<u64>,
}

impl LogReader {
    /// Opens an MCAP file and chooses its topics, from the summary or, without one, from the first
    /// 256 MiB of the file.
    ///
    /// # Errors
    /// [`crate::Error::File`]; [`crate::Error::Format`] for a file that is not MCAP or has no depth image or
    /// calibration topic; [`crate::Error::Config`] for a configured topic that is absent or of another type.
    pub fn mcap(path: &Path, config: &Config) -> Result<Self> {
        Self::of(LogFiles::one(path, Format::Mcap)?, config)
    }

    /// As [`Self::mcap`], for a ROS 1 bag and its index.
    ///
    /// # Errors
    /// As [`Self::mcap`].
    pub fn bag(path: &Path, config: &Config) -> Result<Self> {
        Self::of(LogFiles::one(path, Format::Bag)?, config)
    }

    pub(crate) fn of(files: LogFiles, config: &Config) -> Result<Self> {
        let mut frame_count_hint = None;
        let path = &files.path().to_owned();
        let log = Log::open(files, |channels, _| {
            let topics = Topics::choose(channels, config, path)?;
            frame_count_hint = channels.messages(&topics.depth);
            // Frames have no goals.
            let config = Config { goal_topic: String::new(), ..config.clone() };
            let motion = Motion::choose(channels, &config, path)?;
            let camera = LogCamera::new(topics, &config, motion.is_recorded());
            Ok((motion, vec![LogSensor::new("camera", Reader::Camera(Box::new(camera)))]))
        })?;
        Ok(Self { report: log.whole_report(), log, frame_count_hint })
    }
}

impl Recording for LogReader {
    fn next_frame(&mut self) -> Result<Option<RgbdFrame>> {
        let next = self.log.next_of_one();
        self.report = self.log.whole_report();
        Ok(next?.and_then(|observation| match observation.data {
            SensorData::Frame(frame) => Some(*frame),
            SensorData::Scan(_) => None,
        }))
    }

    fn report(&self) -> &ReadReport {
        &self.report
    }

    fn frame_count_hint(&self) -> Option<u64> {
        self.frame_count_hint
    }
}
