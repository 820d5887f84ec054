//! RGB-D frames: a depth image, what goes with it, and where its camera was.

use crate::base::Rigid;
use crate::sensor::CameraModel;

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

    /// These with floats in units of `float_unit_m` metres made metres.
    #[must_use]
    pub fn in_metres(self, float_unit_m: f64) -> Self {
        match self {
            Self::Metres(samples) if float_unit_m != 1.0 => {
                let unit_m = crate::base::single(float_unit_m);
                Self::Metres(samples.into_iter().map(|sample| sample * unit_m).collect())
            }
            other => other,
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
    /// Why colour is missing or cannot be used with depth, where the source knows.
    pub color_missing: Option<String>,
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
