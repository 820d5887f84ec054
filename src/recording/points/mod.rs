//! Lidar scans in: `PointCloud2`, Foxglove point clouds, Velodyne packets (messages and pcap), PLY and PCD, one scan
//! at a time.
//!
//! [`open`] finds the reader by a file's content. The decoders below it take bytes and give values: [`cloud`],
//! [`pcd`], [`ply`] and [`velodyne`].

pub mod cloud;
mod dropped;
mod fields;
mod files;
mod lzf;
mod open;
mod pcap;
pub mod pcd;
pub mod ply;
mod returns;
mod table;
pub mod velodyne;

pub use self::dropped::{DropReason, Dropped};
pub use self::files::FileScans;
pub use self::open::open;
pub use self::pcap::PcapScans;
pub use self::returns::{ReturnCodes, ReturnType, Strength};
use super::ReadReport;
pub use super::log::LogScans;
use crate::error::Result;

/// A measured point, laid out as it is uploaded: 32 bytes, two `vec4<u32>` of a storage buffer.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::NoUninit)]
pub struct Point {
    /// Forward, metres, in the scan's frame (REP 103).
    pub x_m: f32,
    /// Left, metres.
    pub y_m: f32,
    /// Up, metres.
    pub z_m: f32,
    /// In the sensor's own unit (0 to 255 for Velodyne).
    pub intensity: f32,
    /// Time of the firing after the scan's stamp, seconds; negative where the stamp is that of the scan's end.
    pub time_s: f32,
    /// Laser by elevation as the source numbers it (0 is the lowest for Velodyne); [`Self::UNKNOWN`] where not known,
    /// which sources give as 65535.
    pub ring: u16,
    /// Firing by azimuth within the scan, from 0; [`Self::UNKNOWN`] where not known.
    pub column: u16,
    /// The slot of the beam's returns that the point comes from.
    pub return_type: ReturnType,
    /// Which of the beam's two returns is the stronger.
    pub strength: Strength,
    /// Fills the word; 0.
    pub reserved: u16,
    /// Class of the point in a labelled cloud; [`Self::UNLABELLED`] in others.
    pub label: u32,
}

impl Point {
    /// Ring or column of a point whose place in the grid of beams is not known.
    pub const UNKNOWN: u16 = u16::MAX;

    /// Label of a point in a cloud without labels.
    pub const UNLABELLED: u32 = u32::MAX;

    /// Place, metres.
    pub fn position_m(&self) -> [f32; 3] {
        [self.x_m, self.y_m, self.z_m]
    }
}

/// Which of the optional values of its points a scan has.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[allow(clippy::struct_excessive_bools, reason = "one flag for each optional column")]
pub struct Columns {
    /// [`Point::ring`].
    pub ring: bool,
    /// [`Point::column`]: with the rings an organized cloud.
    pub column: bool,
    /// [`Point::time_s`]; 0 where absent.
    pub time: bool,
    /// [`Point::return_type`]; [`ReturnType::Single`] where absent.
    pub return_type: bool,
    /// [`Point::label`].
    pub label: bool,
}

/// One revolution of a lidar, or whatever else its source gives as one cloud.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// Number of the scan in its recording, from 0; scans that were skipped have none.
    pub index: u64,
    /// Time that [`Point::time_s`] counts from, nanoseconds since the Unix epoch; 0 where the source has none.
    pub stamp_ns: u64,
    /// The sensor's frame; empty where the source has none.
    pub frame_id: String,
    /// The points in the order of the source; all their values are finite.
    pub points: Vec<Point>,
    /// Which optional values the points have.
    pub columns: Columns,
    /// What was left out, by reason.
    pub dropped: Dropped,
}

/// How scans are read.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Options {
    /// Topic in an MCAP file or a bag; `None`: found by message type, packets before clouds.
    pub topic: Option<String>,
    /// Model of a Velodyne sensor; `None`: from the packets.
    pub model: Option<velodyne::Model>,
    /// Meaning of the numbers in a cloud's `return_type` field.
    pub return_codes: ReturnCodes,
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

    /// Log time of the newest message read, where the recording is a log of messages, nanoseconds. Its clock need not be
    /// that of stamps.
    fn log_time_ns(&self) -> Option<u64> {
        None
    }

    /// How many scans the recording says it holds, where it does.
    fn scan_count_hint(&self) -> Option<u64>;
}
