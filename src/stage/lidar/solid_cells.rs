//! The solidity layer of the map (spec 4 §1): the classes of a scan's cells, kept until a scan says something else of them.
//!
//! It is written by the pass that finds the classes. Where the map has cameras too, a free cell keeps between which heights
//! beams crossed it: the pass over points then leaves how far beams reached, by sector and slope.

use crate::base::Result;
use crate::gpu::{Plan, ShaderSource};
use crate::stage::LidarJob;
use crate::stage::lidar::intensity_classes;
use crate::stage::map::layers::Layers;

/// The pass, in a map of lidars alone.
pub const SOLID_CELLS: ShaderSource = ShaderSource {
    name: "intensity_classes",
    parts: &[
        include_str!("../../../shaders/lib/scan.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/record.wgsl"),
        include_str!("../../../shaders/lib/crossing/across_none.wgsl"),
        include_str!("../../../shaders/lib/solid/layer.wgsl"),
        include_str!("../../../shaders/intensity_classes.wgsl"),
    ],
};

/// The pass, in a map with cameras.
pub const SOLID_CELLS_AND_BEAMS: ShaderSource = ShaderSource {
    name: "intensity_classes",
    parts: &[
        include_str!("../../../shaders/lib/scan.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/record.wgsl"),
        include_str!("../../../shaders/lib/crossing/bins.wgsl"),
        include_str!("../../../shaders/lib/crossing/across.wgsl"),
        include_str!("../../../shaders/lib/solid/layer.wgsl"),
        include_str!("../../../shaders/intensity_classes.wgsl"),
    ],
};

crate::params! {
    /// Parameters of the layer, beside those of `intensity_classes`.
    pub struct SolidCellsParams {
        /// Tick of the scan.
        pub tick: u32,
        /// The lidar's number among the sensors, + 1.
        pub sensor: u32,
        /// Height of the lidar above the ground.
        pub lidar_height_m: f32,
        /// Unused.
        pub pad: u32,
    }
}

/// The parameters of one scan of the sensor of that number, counted from 0.
pub fn params(tick: u32, sensor: u32, lidar_height_m: f32) -> SolidCellsParams {
    SolidCellsParams { tick, sensor: sensor + 1, lidar_height_m, pad: 0 }
}

/// Declares the layer and the buffers of `intensity_classes`, and appends the pass; `cameras`: whether the map has some.
///
/// # Errors
/// From the plan.
pub fn declare(plan: &mut Plan, job: &LidarJob, cameras: bool) -> Result<()> {
    Layers { lidars: true, ..Layers::default() }.declare(plan, job.map.side)?;
    plan.uniform::<SolidCellsParams>("solid_cells_params")?;
    intensity_classes::append(plan, job, if cameras { SOLID_CELLS_AND_BEAMS } else { SOLID_CELLS })
}
