//! The lidar map's window, moved by whole cells (spec 2 §3): what is remembered stays where it is in the map.

use crate::error::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::lidar::{ScanJob, ScanMoment, ScanStage};

/// The pass.
pub const SCAN_WINDOW: ShaderSource = ShaderSource {
    name: "scan_window",
    parts: &[
        include_str!("../../shaders/lib/scan.wgsl"),
        include_str!("../../shaders/lib/slot.wgsl"),
        include_str!("../../shaders/scan_window.wgsl"),
    ],
};

/// Sectors around the lidar, as in `shaders/lib/scan.wgsl`.
pub const SECTORS: u32 = 720;

crate::params! {
    /// Parameters of `scan_window`.
    pub struct ScanWindowParams {
        /// Cells along a side.
        pub side: u32,
        /// Slot of window cell (0, 0) along x.
        pub origin_slot_x: u32,
        /// Slot of window cell (0, 0) along y.
        pub origin_slot_y: u32,
        /// Cells moved along x.
        pub shift_x: i32,
        /// Cells moved along y.
        pub shift_y: i32,
        /// 1: nothing is remembered.
        pub forget: u32,
        /// Layers.
        pub layers: u32,
        /// Unused.
        pub pad: u32,
    }
}

/// The stage.
#[derive(Debug)]
pub struct ScanWindow;

impl ScanStage for ScanWindow {
    fn append(&self, plan: &mut Plan, job: &ScanJob) -> Result<()> {
        plan.uniform::<ScanWindowParams>("scan_window_params")?;
        plan.scratch("layer_sums", job.grid_bytes(8 * u64::from(job.layer_count())))?;
        plan.scratch("sector_range", 8 * u64::from(SECTORS))?;
        plan.scratch("inflation", job.grid_bytes(8))?;
        plan.state("remembered", job.grid_bytes(4))?;
        plan.step(SCAN_WINDOW, Invocations::line(job.cells().max(SECTORS)), &[])
    }

    fn write(&self, moment: &ScanMoment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let side = moment.job.side();
        let [origin_slot_x, origin_slot_y] = moment.window.origin_slot(side);
        let [shift_x, shift_y] = moment.window.shift;
        let params = ScanWindowParams {
            side,
            origin_slot_x,
            origin_slot_y,
            shift_x,
            shift_y,
            forget: u32::from(moment.window.forget),
            layers: moment.job.layer_count(),
            pad: 0,
        };
        input.set("scan_window_params", &params)
    }
}
