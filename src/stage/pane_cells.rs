//! Panes of glass as cells of the map (spec 3 §7).

use glam::Vec4;

use crate::error::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::lidar::{ScanJob, ScanMoment, ScanStage};
use crate::stage::{rows, single};

/// The pass.
pub const PANE_CELLS: ShaderSource = ShaderSource {
    name: "pane_cells",
    parts: &[
        include_str!("../../shaders/lib/scan.wgsl"),
        include_str!("../../shaders/lib/glass/pane.wgsl"),
        include_str!("../../shaders/pane_cells.wgsl"),
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
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
    }
}

/// The stage.
#[derive(Debug)]
pub struct PaneCells;

impl ScanStage for PaneCells {
    fn append(&self, plan: &mut Plan, job: &ScanJob) -> Result<()> {
        plan.uniform::<PaneCellsParams>("pane_cells_params")?;
        plan.step(PANE_CELLS, Invocations::area(job.side(), job.side()), &[])
    }

    fn write(&self, moment: &ScanMoment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let [window_from_lidar_x, window_from_lidar_y, window_from_lidar_z] =
            rows(moment.window_from_lidar_at_stamp);
        let params = PaneCellsParams {
            window_from_lidar_x,
            window_from_lidar_y,
            window_from_lidar_z,
            side: moment.job.side(),
            resolution_m: single(moment.job.config.scan_resolution_m),
            pad0: 0,
            pad1: 0,
        };
        input.set("pane_cells_params", &params)
    }
}
