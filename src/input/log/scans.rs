//! The scans of one lidar of a log, without poses.

use std::path::Path;

use crate::base::Result;
use crate::config::Config;
use crate::input::log::choose::scan_topic;
use crate::input::log::lidar::LogLidar;
use crate::input::log::motion::Motion;
use crate::input::log::reading::Log;
use crate::input::log::sensor::{LogSensor, Reader};
use crate::input::log::{Format, LogFiles};
use crate::input::points::{Options, ScanReport, Scans};
use crate::sensor::Scan;

/// Reads the scans of one topic; see [`Scans`].
///
/// A `VelodyneScan` whose packets make a revolution is one scan, as its driver cut it; smaller ones are joined and cut
/// where the azimuth wraps.
pub struct LogScans {
    log: Log,
    report: ScanReport,
    scan_count_hint: Option<u64>,
}

impl LogScans {
    /// Opens an MCAP file and chooses the topic, from the summary or, without one, from the first 256 MiB of the file.
    ///
    /// # Errors
    /// [`crate::Error::File`]; [`crate::Error::Format`] for a file that is not MCAP or has no topic with scans;
    /// [`crate::Error::Config`] for a stated topic that is absent or of another type.
    pub fn mcap(path: &Path, options: &Options) -> Result<Self> {
        Self::of(LogFiles::one(path, Format::Mcap)?, options)
    }

    /// As [`Self::mcap`], for a ROS 1 bag and its index.
    ///
    /// # Errors
    /// As [`Self::mcap`].
    pub fn bag(path: &Path, options: &Options) -> Result<Self> {
        Self::of(LogFiles::one(path, Format::Bag)?, options)
    }

    pub(crate) fn of(files: LogFiles, options: &Options) -> Result<Self> {
        let mut scan_count_hint = None;
        let path = &files.path().to_owned();
        let log = Log::open(files, |channels, report| {
            let stated = options.topic.as_deref().unwrap_or_default();
            let topic = scan_topic(channels, stated, "topic", path, report)?;
            scan_count_hint = channels.messages(&topic);
            let lidar = LogLidar::new(topic, options.clone(), &Config::default(), true);
            Ok((Motion::unread(path)?, vec![LogSensor::new("lidar", Reader::Lidar(Box::new(lidar)))]))
        })?;
        let report = ScanReport { read: log.whole_report(), ..ScanReport::default() };
        Ok(Self { log, report, scan_count_hint })
    }

    fn next(&mut self) -> Result<Option<Scan>> {
        loop {
            if let Some(LogSensor { reader: Reader::Lidar(lidar), .. }) = self.log.sensors.first_mut()
                && let Some(scan) = lidar.next_scan()
            {
                return Ok(Some(scan));
            }
            if self.log.at_end {
                return Ok(None);
            }
            self.log.step()?;
        }
    }
}

impl Scans for LogScans {
    fn next_scan(&mut self) -> Result<Option<Scan>> {
        let next = self.next();
        self.report = self.log.scan_report();
        next
    }

    fn report(&self) -> &ScanReport {
        &self.report
    }

    fn scan_count_hint(&self) -> Option<u64> {
        self.scan_count_hint
    }
}
