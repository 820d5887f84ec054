//! Panes of glass as cells of the map (spec 3 §7).
//!
//! A pane marks cells where it reaches into the heights of obstacles, `height_min_m` to `height_max_m` above the ground at
//! `ground_z_m` in the map; its edges are known to 0.3 m, which counts for it. So a window high above the robot marks none.
//! Where the map is the lidar's own frame ([`SensorPose::SENSOR`], a recording without poses) the ground is not known: there a
//! pane counts whatever its height.

use std::sync::Arc;

use glam::Vec4;

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::sensor::SensorPose;
use crate::stage::lidar::Placed;
use crate::stage::{LidarJob, Moment, Stage, rows, single};

/// The pass.
pub const PANE_CELLS: ShaderSource = ShaderSource {
    name: "pane_cells",
    parts: &[
        include_str!("../../../shaders/lib/scan.wgsl"),
        include_str!("../../../shaders/lib/glass/pane.wgsl"),
        include_str!("../../../shaders/pane_cells.wgsl"),
    ],
};

crate::params! {
    /// Parameters of `pane_cells`.
    pub struct PaneCellsParams {
        /// Rotation and translation of the lidar in the window at the stamp, row x; z = 0 is the lidar's height.
        pub window_from_lidar_x: Vec4,
        /// Row y.
        pub window_from_lidar_y: Vec4,
        /// Row z.
        pub window_from_lidar_z: Vec4,
        /// Cells along a side.
        pub side: u32,
        /// Side of a cell.
        pub resolution_m: f32,
        /// Lowest height of what is in the way, from the lidar's height, metres.
        pub band_low_m: f32,
        /// Highest.
        pub band_high_m: f32,
        /// Whether panes count whatever their height: 0 or 1.
        pub any_height: u32,
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
        /// Unused.
        pub pad2: u32,
    }
}

/// The stage.
#[derive(Debug)]
pub struct PaneCells {
    /// What it is built for.
    pub job: Arc<LidarJob>,
}

impl Stage for PaneCells {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let job = &*self.job;
        plan.uniform::<PaneCellsParams>("pane_cells_params")?;
        plan.step(PANE_CELLS, Invocations::area(job.side, job.side), &[])
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let placed = Placed::of(moment, self.job.deskew);
        let [window_from_lidar_x, window_from_lidar_y, window_from_lidar_z] =
            rows(placed.window_from_lidar_at_stamp);
        let config = &self.job.config;
        // From the lidar's height.
        let ground_m = config.ground_z_m - placed.lidar_z_m;
        let params = PaneCellsParams {
            window_from_lidar_x,
            window_from_lidar_y,
            window_from_lidar_z,
            side: self.job.side,
            resolution_m: single(config.scan_resolution_m),
            band_low_m: single(ground_m + config.height_min_m),
            band_high_m: single(ground_m + config.height_max_m),
            any_height: u32::from(moment.pose == SensorPose::SENSOR),
            pad0: 0,
            pad1: 0,
            pad2: 0,
        };
        input.set("pane_cells_params", &params)
    }
}
