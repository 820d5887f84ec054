//! Lidar scans in: `PointCloud2`, Foxglove point clouds, Velodyne packets (messages, pcap, pcapng), PLY and PCD, one scan
//! at a time.
//!
//! [`open`] finds the reader by a file's content. The decoders below it take bytes and give values: [`cloud`],
//! [`pcd`], [`ply`] and [`velodyne`].

mod capture;
pub mod cloud;
mod fields;
mod files;
pub mod laser;
pub mod livox;
mod lzf;
mod open;
mod pcap;
pub mod pcd;
pub mod ply;
mod table;
mod times;
pub mod velodyne;

use crate::base::Result;
use crate::config::Config;
use crate::input::ReadReport;
pub use crate::input::log::LogScans;
pub use crate::input::points::files::FileScans;
pub use crate::input::points::open::open;
pub use crate::input::points::pcap::PcapScans;
use crate::message::decode_error;
use crate::sensor::{Dropped, Point, ReturnCodes, Scan, VelodyneModel};

/// Most points of a scan in a message.
const MOST_POINTS: u64 = 1 << 22;

/// Refuses a scan in a message `what` that has, or says that it has, too many points, before memory is taken for them.
///
/// # Errors
/// [`crate::Error::Decode`] with the number of points.
pub(crate) fn check_points(what: &str, points: u64) -> Result<()> {
    if points > MOST_POINTS {
        return Err(decode_error(what, format!("{points} points; at most {MOST_POINTS} are read")));
    }
    Ok(())
}

/// Farthest that half of a scan's points may lie from the sensor, metres: more than any lidar sees.
const FARTHEST_M: f32 = 1000.0;

/// Refuses a scan whose coordinates cannot be metres: all that it holds would lie outside the map, and its beams would clear it.
///
/// # Errors
/// [`crate::Error::Decode`] with the median distance.
pub(crate) fn check_reach(what: &str, scan: &Scan) -> Result<()> {
    let step = (scan.points.len() / 1024).max(1);
    let distance = |point: &Point| point.position_m().iter().map(|value| value * value).sum::<f32>().sqrt();
    let mut distances: Vec<f32> = scan.points.iter().step_by(step).map(distance).collect();
    let middle = distances.len() / 2;
    let median_m = match distances.get(middle) {
        Some(_) => *distances.select_nth_unstable_by(middle, f32::total_cmp).1,
        None => 0.0,
    };
    if median_m <= FARTHEST_M {
        return Ok(());
    }
    let reason = format!(
        "half of its points lie more than {median_m:.0} m from the sensor: are its coordinates millimetres, or of a map? They must \
         be metres in the sensor's frame"
    );
    Err(decode_error(what, reason))
}

/// How scans are read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Options {
    /// Topic in an MCAP file or a bag; `None`: found by message type, packets before clouds.
    pub topic: Option<String>,
    /// Model of a Velodyne sensor; `None`: from the packets.
    pub model: Option<VelodyneModel>,
    /// UDP port of a capture's data packets; `None`: 2368.
    pub port: Option<u16>,
    /// Field of clouds that holds the intensity; `None`: found by name.
    pub intensity_field: Option<String>,
    /// Meaning of the numbers in a cloud's `return_type` field.
    pub return_codes: ReturnCodes,
}

impl Options {
    /// As a configuration has them.
    pub(crate) fn of(config: &Config) -> Self {
        Self {
            topic: Some(config.scan_topic.clone()).filter(|topic| !topic.is_empty()),
            model: config.velodyne_model,
            port: Some(config.velodyne_port),
            intensity_field: Some(config.intensity_field.clone()).filter(|field| !field.is_empty()),
            return_codes: config.return_codes,
        }
    }
}

/// What a reader of scans met, complete once `next_scan` has returned `None`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ScanReport {
    /// Scans given.
    pub scans: u64,
    /// Points in them.
    pub points: u64,
    /// Points left out of them, by reason.
    pub dropped: Dropped,
    /// Messages and packets passed over, and notes; its count of depth images stays 0.
    pub read: ReadReport,
}

impl ScanReport {
    /// Numbers a scan and counts it in.
    pub(crate) fn count(&mut self, scan: &mut Scan) {
        scan.index = self.scans;
        scan.columns.clock.note().into_iter().for_each(|note| self.read.note(note));
        self.scans += 1;
        self.points += scan.points.len() as u64;
        self.dropped.add_all(scan.dropped);
    }

    /// Counts a scan that is not given, as it has no points.
    pub(crate) fn count_empty(&mut self, source: &str, scan: &Scan) {
        self.dropped.add_all(scan.dropped);
        self.read.skip(source, "the cloud has no points", scan.stamp_ns);
    }
}

/// A stream of scans in the order of the recording, one in memory at a time.
pub trait Scans {
    /// The next scan that has points, or `None` at the end (a cut-off file ends at its cut, with a note).
    ///
    /// # Errors
    /// Only what ends the recording, such as an unreadable file; bad messages and packets are counted in the report.
    fn next_scan(&mut self) -> Result<Option<Scan>>;

    /// What was met so far.
    fn report(&self) -> &ScanReport;

    /// How many scans the recording says it holds, where it does.
    fn scan_count_hint(&self) -> Option<u64>;
}
