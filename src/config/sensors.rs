//! The sensors that a configuration names (spec 4 §1).

use super::Config;

/// What a sensor measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorKind {
    /// Depth images, with or without colour.
    Camera,
    /// Scans.
    Lidar,
}

impl SensorKind {
    /// The kind as a file states it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Lidar => "lidar",
        }
    }
}

/// A sensor that the configuration names.
#[derive(Debug, Clone, PartialEq)]
pub struct SensorConfig {
    /// Its name: that of its section.
    pub name: String,
    /// What it measures.
    pub kind: SensorKind,
    /// Time without data after which it is stale, seconds; 0: never.
    pub timeout_s: f64,
    /// The parameters that hold for it: those of all, with its section laid over them. Its own list of sensors is empty.
    pub parameters: Config,
}
