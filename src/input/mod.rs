//! Recordings in: MCAP, bags of ROS 1 and rosbag2, TUM folders, still pairs, lidar files, all streaming.

mod apart;
mod bag;
pub(crate) mod calibration;
mod calibrations;
mod color_layout;
mod db3;
mod event;
mod exr_decode;
mod frames;
pub mod image_decode;
mod image_message;
mod inventory;
mod log;
mod mcap;
mod nothing;
mod open;
#[cfg(feature = "ros2")]
pub mod playback;
pub mod points;
mod pose;
mod posed;
mod report;
mod rvl;
mod scan_pose;
mod single;
mod source;
mod start;
mod stated;
mod still;
mod sync;
pub mod transforms;
mod tum;
mod zstd_frame;

use crate::base::Result;
use crate::sensor::RgbdFrame;

pub(crate) use crate::input::exr_decode::depth_from_exr;
pub use crate::input::inventory::{FrameInfo, Inventory, TopicInfo};
pub use crate::input::log::{Contents, LogReader};
#[cfg(feature = "ros2")]
pub(crate) use crate::input::log::{LiveSource, LiveTopic};
pub(crate) use crate::input::log::{Record, Records};
pub(crate) use crate::input::mcap::McapRecords;
pub use crate::input::open::{contents, open};
pub use crate::input::posed::PosedScans;
pub use crate::input::source::{SensorReport, Source, SourceReport, open_source};
pub use crate::input::still::StillReader;
pub use crate::input::tum::{TumReader, trajectory};

/// Something the reader passed over, counted by topic and reason.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Skipped {
    /// Topic or file name.
    pub source: String,
    /// Why, without stamps, so that equal reasons are counted together.
    pub reason: String,
    /// Stamp of the first one, nanoseconds.
    pub first_stamp_ns: u64,
    /// How many.
    pub count: u64,
}

/// What a reader met on its way, complete once `next_frame` has returned `None`.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct ReadReport {
    /// Depth images seen.
    pub depth_images: u64,
    /// Messages and images passed over.
    pub skipped: Vec<Skipped>,
    /// Things a user should know: a cut-off file, topics chosen by type, a base frame derived.
    pub notes: Vec<String>,
    /// What of its files is damaged, missing or passed over; also among the notes.
    pub damage: Vec<String>,
    /// Of each sensor that has no poses: why, which frames there are, and which keys to set.
    pub frames: Vec<String>,
}

/// A stream of RGB-D frames in order of time; never holds more than a bounded window in memory.
pub trait Recording {
    /// The next frame, or `None` at the end (a cut-off file ends at its cut, with a note in the report).
    ///
    /// # Errors
    /// Only what ends the recording: an unreadable file, a missing calibration for the whole file.
    /// Single bad messages are counted in the report and skipped.
    fn next_frame(&mut self) -> Result<Option<RgbdFrame>>;

    /// What was met so far.
    fn report(&self) -> &ReadReport;

    /// How many depth images the recording says it holds, where it says so without being read.
    fn frame_count_hint(&self) -> Option<u64>;
}
