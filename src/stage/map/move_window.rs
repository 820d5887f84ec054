//! The rolling window (spec 1 §3): a ring buffer of cells, moved by whole cells.

use std::sync::Arc;

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderText};
use crate::map::Window;
use crate::stage::map::layers::Layers;
use crate::stage::{MapJob, Moment, Stage};

/// The files of the pass over those layers; `frame`: whether it clears the sums of a camera's frame too.
pub fn parts(layers: Layers, frame: bool) -> [&'static str; 10] {
    [
        include_str!("../../../shaders/lib/cell.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/counters.wgsl"),
        if frame {
            include_str!("../../../shaders/lib/window/frame.wgsl")
        } else {
            include_str!("../../../shaders/lib/window/no_frame.wgsl")
        },
        if layers.cameras {
            include_str!("../../../shaders/lib/window/cameras.wgsl")
        } else {
            include_str!("../../../shaders/lib/window/no_cameras.wgsl")
        },
        if layers.looks {
            include_str!("../../../shaders/lib/window/looks.wgsl")
        } else {
            include_str!("../../../shaders/lib/window/no_looks.wgsl")
        },
        if layers.lidars {
            include_str!("../../../shaders/lib/window/lidars.wgsl")
        } else {
            include_str!("../../../shaders/lib/window/no_lidars.wgsl")
        },
        if layers.panes {
            include_str!("../../../shaders/lib/window/panes.wgsl")
        } else {
            include_str!("../../../shaders/lib/window/no_panes.wgsl")
        },
        if layers.drops {
            include_str!("../../../shaders/lib/window/drops.wgsl")
        } else {
            include_str!("../../../shaders/lib/window/no_drops.wgsl")
        },
        include_str!("../../../shaders/move_window.wgsl"),
    ]
}

/// The pass over those layers.
pub fn shader(layers: Layers, frame: bool) -> ShaderText {
    let text = parts(layers, frame).join("\n");
    ShaderText { label: "move_window".into(), entry_point: "move_window", text }
}

/// The parameters for a window of `side` x `side` cells.
pub fn params(window: &Window, side: u32) -> MoveWindowParams {
    let [origin_slot_x, origin_slot_y] = window.origin_slot(side);
    let [shift_x, shift_y] = window.shift;
    let forget = u32::from(window.forget);
    MoveWindowParams { side, origin_slot_x, origin_slot_y, shift_x, shift_y, forget }
}

/// Declares the layers and, for a `frame` of a camera, its sums, and appends the pass.
///
/// # Errors
/// From the plan.
pub fn declare(plan: &mut Plan, side: u32, layers: Layers, frame: bool) -> Result<()> {
    layers.declare(plan, side)?;
    plan.uniform::<MoveWindowParams>("move_window_params")?;
    if frame {
        sums(plan, side)?;
    }
    // A row as long as the counters are many, however small the window is.
    plan.step(shader(layers, frame), Invocations::area(side.max(8), side), &[])
}

fn sums(plan: &mut Plan, side: u32) -> Result<()> {
    let cells = u64::from(side) * u64::from(side);
    plan.scratch("cell_hits", cells * 16)?;
    plan.scratch("seen_through", cells * 4)?;
    plan.scratch("counters", COUNTERS * 4).map(|_| ())
}

/// Counters of a frame, in the order of `shaders/lib/counters.wgsl`.
pub const COUNTERS: u64 = 8;

crate::params! {
    /// Parameters of `move_window`.
    pub struct MoveWindowParams {
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
        /// 1: every cell starts unknown.
        pub forget: u32,
    }
}

/// The stage.
#[derive(Debug)]
pub struct MoveWindow {
    /// What it is built for.
    pub map: Arc<MapJob>,
    /// Whether it clears the sums of a camera's frame too.
    pub frame: bool,
}

impl Stage for MoveWindow {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        declare(plan, self.map.side, self.map.layers, self.frame)
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let window = &moment.window;
        if !self.frame && window.shift == [0, 0] && !window.forget {
            // Nothing left the window, and there are no sums to clear.
            input.limit("move_window", Invocations::area(1, 1))?;
        }
        input.set("move_window_params", &params(window, self.map.side))
    }
}
