//! Lidar scans: points with intensity, ring, time and return.

use crate::sensor::{Dropped, ReturnType, Strength};

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
