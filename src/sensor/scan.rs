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

/// What a source's times of points count from.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum PointClock {
    /// The scan's stamp, or 1970 as that does.
    #[default]
    Stamp,
    /// A start of their own, such as the sensor's boot: they are taken to begin at the stamp.
    Own,
    /// 1970, in 32 bits: no times that can be used.
    Rounded,
    /// They lie too far apart to be of one scan: no times that can be used.
    Spread,
}

impl PointClock {
    /// What a user should know of such times.
    pub fn note(self) -> Option<&'static str> {
        match self {
            Self::Stamp => None,
            Self::Own => Some(
                "times of points count from another clock than the stamps: the first point of a scan is taken to be of its stamp",
            ),
            Self::Rounded => Some(
                "times of points are seconds since 1970 in 32 bits, which is too coarse: scans are not deskewed",
            ),
            Self::Spread => {
                Some("times of points lie more than 10 s apart within a scan: scans are not deskewed")
            }
        }
    }

    /// Whether points have times.
    pub(crate) fn is_usable(self) -> bool {
        matches!(self, Self::Stamp | Self::Own)
    }
}

/// Which of the optional values of its points a scan has: by default intensity alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::struct_excessive_bools, reason = "one flag for each optional column")]
pub struct Columns {
    /// [`Point::intensity`]; 0 where absent.
    pub intensity: bool,
    /// [`Point::ring`].
    pub ring: bool,
    /// [`Point::column`]: with the rings an organized cloud.
    pub column: bool,
    /// [`Point::time_s`]; 0 where absent.
    pub time: bool,
    /// What the source's times count from.
    pub clock: PointClock,
    /// [`Point::return_type`]; [`ReturnType::Single`] where absent.
    pub return_type: bool,
    /// [`Point::label`].
    pub label: bool,
}

impl Default for Columns {
    fn default() -> Self {
        Self {
            intensity: true,
            ring: false,
            column: false,
            time: false,
            clock: PointClock::Stamp,
            return_type: false,
            label: false,
        }
    }
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
