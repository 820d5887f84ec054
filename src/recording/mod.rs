//! Recordings in (MCAP, ROS 1 bags, TUM) and out (MCAP, PNG, EXR, map_server), all streaming.

mod bag;
mod event;
mod exr_decode;
pub mod image_decode;
mod image_message;
mod log;
mod mcap;
pub mod message;
mod open;
pub mod points;
mod pose;
mod posed;
mod report;
mod still;
mod sync;
pub mod transforms;
mod tum;

use crate::camera::CameraModel;
use crate::error::Result;
use crate::geometry::Rigid;

pub mod write;

pub(crate) use self::exr_decode::depth_from_exr;
pub use self::log::{Contents, LogReader};
pub(crate) use self::log::{Record, Records};
pub(crate) use self::mcap::McapRecords;
pub use self::open::{contents, open};
pub use self::posed::PosedScans;
pub use self::still::StillReader;
pub use self::tum::{TumReader, trajectory};

/// A depth image on its native grid, row-major from the top left.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthImage {
    /// Time of capture, nanoseconds since the Unix epoch.
    pub stamp_ns: u64,
    /// The optical frame's name.
    pub frame_id: String,
    /// Calibration; its width and height are those of the samples.
    pub camera: CameraModel,
    /// `width * height` samples.
    pub samples: DepthSamples,
}

/// Depth samples as the sensor wrote them; 0, 65535 (integers), NaN and infinity mean "no depth".
#[derive(Debug, Clone, PartialEq)]
pub enum DepthSamples {
    /// Integers in units of `unit_m` metres.
    Integer {
        /// The samples.
        raw: Vec<u16>,
        /// Metres per count (0.001 for millimetres).
        unit_m: f64,
    },
    /// Metres.
    Metres(Vec<f32>),
}

impl DepthSamples {
    /// Number of samples.
    pub fn len(&self) -> usize {
        match self {
            Self::Integer { raw, .. } => raw.len(),
            Self::Metres(samples) => samples.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A colour image, 8 bits a channel, row-major RGB.
#[derive(Debug, Clone, PartialEq)]
pub struct ColorImage {
    /// Time of capture, nanoseconds since the Unix epoch.
    pub stamp_ns: u64,
    /// Calibration; its width and height are those of the pixels.
    pub camera: CameraModel,
    /// `3 * width * height` bytes.
    pub rgb: Vec<u8>,
}

/// Where the sensor and the robot were when a depth image was taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FramePose {
    /// Robot base in the map.
    pub map_from_base: Rigid,
    /// Depth camera's optical frame in the robot base.
    pub base_from_camera: Rigid,
}

/// One moment of an RGB-D recording: depth, and what goes with it.
#[derive(Debug, Clone, PartialEq)]
pub struct RgbdFrame {
    /// Number of the depth image in the recording, counted from 0, unusable ones included.
    pub index: u64,
    /// The depth image.
    pub depth: DepthImage,
    /// The colour image nearest in time within the tolerance, if any.
    pub color: Option<ColorImage>,
    /// Colour camera from depth camera (optical frames); identity where the images are aligned
    /// (same frame), `None` without colour or where the transform is unknown.
    pub color_from_depth: Option<Rigid>,
    /// The sensor's own confidence on the depth grid, in [0, 1], `width * height` values.
    pub confidence: Option<Vec<f32>>,
    /// `None` where the transform tree does not reach from map to camera at this stamp.
    pub pose: Option<FramePose>,
}

impl RgbdFrame {
    /// Whether there is colour and it lies on the depth grid: same frame, same calibration.
    pub fn color_is_aligned(&self) -> bool {
        let same = |color: &ColorImage| color.camera == self.depth.camera;
        self.color.as_ref().is_some_and(same) && self.color_from_depth == Some(Rigid::IDENTITY)
    }
}

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
