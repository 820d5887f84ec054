//! What is known of a sensor before its first observation: what the passes are built for.

use crate::sensor::{CameraModel, Scan};

/// Kind of a sensor, with what is known of it.
#[derive(Debug, Clone, PartialEq)]
pub enum SensorModel {
    /// A depth camera.
    Camera(CameraInfo),
    /// A lidar.
    Lidar(LidarInfo),
    /// Configured, and nothing of it came.
    Missing,
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
