//! What is known of a sensor before its first observation: what the passes are built for.

use crate::sensor::{CameraModel, DepthSamples, RgbdFrame, Scan};

/// What a sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorKind {
    /// Depth images, with or without colour.
    Camera,
    /// Scans.
    Lidar,
}

impl SensorKind {
    /// Both kinds.
    pub const ALL: [Self; 2] = [Self::Camera, Self::Lidar];

    /// The kind as a file states it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Lidar => "lidar",
        }
    }
}

/// Kind of a sensor, with what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub enum SensorModel {
    /// A depth camera.
    Camera(CameraInfo),
    /// A lidar.
    Lidar(LidarInfo),
    /// Configured, and nothing of it came in the first 10 s of stamps.
    Missing(SensorKind),
}

impl SensorModel {
    /// What it measures.
    pub fn kind(&self) -> SensorKind {
        match self {
            Self::Camera(_) => SensorKind::Camera,
            Self::Lidar(_) => SensorKind::Lidar,
            Self::Missing(kind) => *kind,
        }
    }
}

/// Size, encoding and calibrations of a depth camera's images.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraInfo {
    /// Calibration of the depth images.
    pub depth: CameraModel,
    /// Whether depth comes as float metres (else as 16-bit counts).
    pub float_depth: bool,
    /// Calibration of the colour images; `None`: there are none.
    pub color: Option<CameraModel>,
    /// Whether these lie on the depth grid in every frame, which is faster; a frame of which it is not true is refused then.
    pub color_aligned: bool,
    /// Whether frames carry the sensor's own confidence.
    pub confidence: bool,
}

/// A lidar's beams and intensities.
#[derive(Debug, Clone, PartialEq)]
pub struct LidarInfo {
    /// A scan, from which the rings of the planes, the grid of beams and the full scale of intensities are taken.
    pub first: Scan,
}

impl CameraInfo {
    /// From the first frames of a camera, of which one with colour tells of that; `None` of no frame.
    pub fn of_frames<'a>(frames: impl IntoIterator<Item = &'a RgbdFrame>) -> Option<Self> {
        let mut frames = frames.into_iter().peekable();
        let first = *frames.peek()?;
        let colored = frames.find(|frame| frame.color.is_some());
        Some(Self {
            depth: first.depth.camera,
            float_depth: matches!(first.depth.samples, DepthSamples::Metres(_)),
            color: colored.and_then(|frame| frame.color.as_ref()).map(|color| color.camera),
            color_aligned: colored.is_some_and(RgbdFrame::color_is_aligned),
            confidence: first.confidence.is_some(),
        })
    }
}
