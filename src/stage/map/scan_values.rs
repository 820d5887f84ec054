//! What a scan left in the map, in the values of its layers (spec 2 §3, §4), for dumps.

use std::sync::Arc;

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::stage::lidar::intensity_classes::solid_value;
use crate::stage::{LidarJob, Moment, Stage, single};

/// The pass, in a map without panes.
pub const SCAN_VALUES: ShaderSource = ShaderSource {
    name: "scan_values",
    parts: &[
        include_str!("../../../shaders/lib/scan.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/values/no_panes.wgsl"),
        include_str!("../../../shaders/scan_values.wgsl"),
    ],
};

/// The pass, in a map with panes.
pub const SCAN_VALUES_AND_PANES: ShaderSource = ShaderSource {
    name: "scan_values",
    parts: &[
        include_str!("../../../shaders/lib/scan.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/values/panes.wgsl"),
        include_str!("../../../shaders/scan_values.wgsl"),
    ],
};

crate::params! {
    /// Parameters of `scan_values`.
    pub struct ScanValuesParams {
        /// Cells along a side.
        pub side: u32,
        /// Slot of window cell (0, 0) along x.
        pub origin_slot_x: u32,
        /// Slot of window cell (0, 0) along y.
        pub origin_slot_y: u32,
        /// Value of a layer that counts fully.
        pub solid_value: f32,
    }
}

/// The stage.
#[derive(Debug)]
pub struct ScanValues {
    /// What it is built for.
    pub job: Arc<LidarJob>,
}

impl Stage for ScanValues {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        let map = &self.job.map;
        if plan.find("inflation").is_none() {
            // Inflated by another law, or with the published map.
            plan.zeroed("inflation", self.job.grid_bytes(4))?;
        }
        plan.uniform::<ScanValuesParams>("scan_values_params")?;
        plan.product("cell_values", self.job.grid_bytes(16))?;
        let pass = if map.layers.panes { SCAN_VALUES_AND_PANES } else { SCAN_VALUES };
        plan.step(pass, Invocations::area(map.side, map.side), &[])
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let side = self.job.map.side;
        let [origin_slot_x, origin_slot_y] = moment.window.origin_slot(side);
        let solid_value = single(solid_value(&self.job));
        input.set("scan_values_params", &ScanValuesParams { side, origin_slot_x, origin_slot_y, solid_value })
    }
}
