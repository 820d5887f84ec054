//! The lidar path: scans in, classified plan maps out, in one GPU submission per scan (spec 2).

mod job;
mod output;
pub mod pipeline;
mod run;

pub use job::{ScanJob, ScanMoment, ScanStage, Turn};
pub use output::{CellClass, ScanLayers, ScanOptions, ScanOutput};
pub use pipeline::ScanPipeline;
pub use run::{ScanRunReport, ScanSink, run_scans};

use glam::DVec2;

use crate::base::Rigid;
use crate::sensor::Scan;

/// Most points of a scan; sums of intensities of that many fit in 32 bits.
pub const MAX_POINTS: usize = 1 << 20;

/// A scan with what the recording says of the robot at that time.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanFrame {
    /// The scan; its points are in the lidar's frame.
    pub scan: Scan,
    /// Frame of the map: `map_frame`, or the lidar's own where the recording has no poses.
    pub map_frame: String,
    /// Where robot and lidar were; `None` where that is unknown at this stamp.
    pub pose: Option<ScanPose>,
    /// The robot's goal in the map, metres; `None`: straight ahead.
    pub goal_m: Option<DVec2>,
}

/// Where robot and lidar were during a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanPose {
    /// Robot base in the map at the scan's stamp.
    pub map_from_base: Rigid,
    /// Lidar in the robot base.
    pub base_from_lidar: Rigid,
    /// The lidar at the times of the scan's first and last point, where points carry time.
    pub sweep: Option<Sweep>,
}

impl ScanPose {
    /// A map that is the lidar's own frame.
    pub const SENSOR: Self =
        Self { map_from_base: Rigid::IDENTITY, base_from_lidar: Rigid::IDENTITY, sweep: None };

    /// Lidar in the map at the scan's stamp.
    pub fn map_from_lidar(&self) -> Rigid {
        self.map_from_base.then(self.base_from_lidar)
    }
}

/// The lidar's motion during a scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sweep {
    /// Time of the first point after the scan's stamp, seconds.
    pub first_s: f32,
    /// Time of the last point after the scan's stamp, seconds.
    pub last_s: f32,
    /// Lidar in the map at the first.
    pub map_from_first: Rigid,
    /// Lidar in the map at the last.
    pub map_from_last: Rigid,
}
