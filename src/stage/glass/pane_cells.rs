//! Panes of glass as cells of the map (spec 3 §7).
//!
//! A pane marks cells where it reaches into the heights of obstacles, `height_min_m` to `height_max_m` above the ground as it is
//! seen, else at `ground_z_m` in the map; its edges are known to 0.3 m, which counts for it. So a window high above the robot marks
//! none. Where no ground was seen and the map is the lidar's own frame ([`SensorPose::SENSOR`], a recording without poses), a pane
//! counts whatever its height.

use std::sync::Arc;

use glam::Vec4;

use crate::base::{Result, Rigid};
use crate::config::Config;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::map::Pane;
use crate::sensor::SensorPose;
use crate::stage::lidar::Placed;
use crate::stage::map::layers::Layers;
use crate::stage::{LidarJob, Moment, Stage, rows, single};

/// The pass that writes the layer of panes.
pub const PANE_CELLS: ShaderSource = ShaderSource {
    name: "pane_cells",
    parts: &[
        include_str!("../../../shaders/lib/record.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/glass/pane.wgsl"),
        include_str!("../../../shaders/pane_cells.wgsl"),
    ],
};

/// The pass that keeps a lidar's panes for the other sensors.
pub const SHARE_PANES: ShaderSource = ShaderSource {
    name: "share_panes",
    parts: &[
        include_str!("../../../shaders/lib/glass/pane.wgsl"),
        include_str!("../../../shaders/share_panes.wgsl"),
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
        /// Lowest height of what is in the way above a ground that is seen, metres.
        pub height_min_m: f32,
        /// Highest.
        pub height_max_m: f32,
        /// Unused.
        pub pad: u32,
    }
}

crate::params! {
    /// Parameters of the layer of panes, beside those of `pane_cells`.
    pub struct PaneLayerParams {
        /// Tick of the scan.
        pub tick: u32,
        /// The lidar's number among the sensors, + 1.
        pub sensor: u32,
        /// First of its panes in `map_panes`.
        pub first: u32,
        /// Slot of window cell (0, 0) along x.
        pub origin_slot_x: u32,
        /// Slot of window cell (0, 0) along y.
        pub origin_slot_y: u32,
    }
}

crate::params! {
    /// Parameters of `share_panes`.
    pub struct SharePanesParams {
        /// Rotation and translation of the lidar in the map's axes from the local origin, row x.
        pub local_from_lidar_x: Vec4,
        /// Row y.
        pub local_from_lidar_y: Vec4,
        /// Row z.
        pub local_from_lidar_z: Vec4,
        /// First of the lidar's panes in `map_panes`.
        pub first: u32,
        /// Tick of the scan.
        pub tick: u32,
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
    }
}

/// Panes that a lidar has in `map_panes`.
pub const PANES_EACH: u32 = 16;

/// A lidar among those that search for glass.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GlassLidar {
    /// Its number among the sensors, from 0.
    pub sensor: u32,
    /// Its number among the lidars that search for glass, from 0.
    pub number: u32,
}

/// The parameters of the layer for a scan at `tick`.
pub fn layer_params(
    tick: u32,
    lidar: GlassLidar,
    [origin_slot_x, origin_slot_y]: [u32; 2],
) -> PaneLayerParams {
    let (sensor, first) = (lidar.sensor + 1, lidar.number * PANES_EACH);
    PaneLayerParams { tick, sensor, first, origin_slot_x, origin_slot_y }
}

/// The parameters of `share_panes` for a scan at `tick`, with the lidar at `local_from_lidar` in the map's axes from the local
/// origin.
pub fn share_params(tick: u32, lidar: GlassLidar, local_from_lidar: Rigid) -> SharePanesParams {
    let [local_from_lidar_x, local_from_lidar_y, local_from_lidar_z] = rows(local_from_lidar);
    let first = lidar.number * PANES_EACH;
    SharePanesParams {
        local_from_lidar_x,
        local_from_lidar_y,
        local_from_lidar_z,
        first,
        tick,
        pad0: 0,
        pad1: 0,
    }
}

/// The parameters of `pane_cells` for the lidar at `window_from_lidar` (z = 0 at its height), `ground_m` above which the ground
/// lies from there; `None`: the ground is not known, and panes count whatever their height.
pub fn params(
    config: &Config,
    side: u32,
    resolution_m: f64,
    window_from_lidar: Rigid,
    ground_m: Option<f64>,
) -> PaneCellsParams {
    let [window_from_lidar_x, window_from_lidar_y, window_from_lidar_z] = rows(window_from_lidar);
    let from_m = ground_m.unwrap_or(0.0);
    PaneCellsParams {
        window_from_lidar_x,
        window_from_lidar_y,
        window_from_lidar_z,
        side,
        resolution_m: single(resolution_m),
        band_low_m: single(from_m + config.height_min_m),
        band_high_m: single(from_m + config.height_max_m),
        any_height: u32::from(ground_m.is_none()),
        height_min_m: single(config.height_min_m),
        height_max_m: single(config.height_max_m),
        pad: 0,
    }
}

/// Declares `map_panes` with room for the panes of `lidars` lidars that search for glass, if the plan does not have it yet.
///
/// # Errors
/// From the plan.
pub fn declare_map_panes(plan: &mut Plan, lidars: u32) -> Result<()> {
    if plan.find_in("", "map_panes").is_none() {
        plan.shared("map_panes", u64::from(lidars * PANES_EACH) * size_of::<Pane>() as u64)?;
    }
    Ok(())
}

/// Declares the layer and `map_panes`, and appends the two passes over `panes`; `lidars`: how many search for glass.
///
/// # Errors
/// From the plan.
pub fn declare(plan: &mut Plan, side: u32, lidars: u32) -> Result<()> {
    Layers { panes: true, ..Layers::default() }.declare(plan, side)?;
    declare_map_panes(plan, lidars)?;
    plan.uniform::<SharePanesParams>("share_panes_params")?;
    plan.uniform::<PaneLayerParams>("pane_layer_params")?;
    plan.uniform::<PaneCellsParams>("pane_cells_params")?;
    plan.step(SHARE_PANES, Invocations::line(PANES_EACH), &[])?;
    plan.step(PANE_CELLS, Invocations::area(side, side), &[("pane_records", "pane_cells")])
}

/// The stage.
#[derive(Debug)]
pub struct PaneCells {
    /// What it is built for.
    pub job: Arc<LidarJob>,
}

impl Stage for PaneCells {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        declare(plan, self.job.map.side, self.job.map.glass_lidars)
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let (job, config) = (&self.job, &self.job.config);
        let placed = Placed::of(moment, job.deskew);
        // From the lidar's height.
        let ground_m = (moment.pose != SensorPose::SENSOR).then_some(config.ground_z_m - placed.lidar_z_m);
        let at = placed.window_from_lidar_at_stamp;
        let lidar = GlassLidar { sensor: job.sensor, number: job.glass_number };
        let share = share_params(moment.tick, lidar, moment.local_from_sensor());
        let origin_slot = moment.window.origin_slot(job.map.side);
        input.set(
            "pane_cells_params",
            &params(config, job.map.side, config.scan_resolution_m, at, ground_m),
        )?;
        input.set("pane_layer_params", &layer_params(moment.tick, lidar, origin_slot))?;
        input.set("share_panes_params", &share)
    }
}
