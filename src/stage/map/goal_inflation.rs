//! Inflation away from the goal (spec 2 §4): the kernel, and its spread over the map.

use std::sync::Arc;

use glam::DVec2;

use crate::base::Result;
use crate::config::{Config, InflationKernel};
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::stage::{MapJob, Moment, Stage};

/// The pass, in a map with lidars.
pub const GOAL_INFLATION_OF_LIDARS: ShaderSource = ShaderSource {
    name: "goal_inflation",
    parts: &[
        include_str!("../../../shaders/lib/scan.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/verdict.wgsl"),
        include_str!("../../../shaders/lib/strength/lidars.wgsl"),
        include_str!("../../../shaders/goal_inflation.wgsl"),
    ],
};

/// The pass, in a map without lidars.
pub const GOAL_INFLATION_OF_CAMERAS: ShaderSource = ShaderSource {
    name: "goal_inflation",
    parts: &[
        include_str!("../../../shaders/lib/scan.wgsl"),
        include_str!("../../../shaders/lib/verdict.wgsl"),
        include_str!("../../../shaders/lib/strength/no_lidars.wgsl"),
        include_str!("../../../shaders/goal_inflation.wgsl"),
    ],
};

/// What a coordinate of a tap is moved up by, as in the shader.
const TAP_ZERO: i32 = 128;

/// Slack of comparisons of distances in cells.
const EPSILON: f64 = 1e-9;

crate::params! {
    /// Parameters of `goal_inflation`.
    pub struct GoalInflationParams {
        /// Cells along a side.
        pub side: u32,
        /// Cells of the kernel.
        pub taps: u32,
        /// How many of them lie within the inscribed radius.
        pub inscribed: u32,
        /// Slot of window cell (0, 0) along x.
        pub origin_slot_x: u32,
        /// Slot of window cell (0, 0) along y.
        pub origin_slot_y: u32,
    }
}

/// The kernel K: the cells, from that of the obstacle, over which it is spread.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kernel {
    /// x and y in cells, those within the inscribed radius first.
    pub taps: Vec<[i32; 2]>,
    /// How many lie within the inscribed radius.
    pub inscribed: usize,
}

/// Cells from the kernel's centre to its border: e = 2 reach + 1.
pub fn reach_cells(config: &Config) -> i32 {
    let cells = |metres: f64| metres / config.scan_resolution_m;
    let farthest = config.inflation_length_m.max(config.inflation_side_m).max(config.inscribed_radius_m);
    #[expect(clippy::cast_possible_truncation, reason = "validated to be at most 64 cells")]
    let reach = (cells(farthest) - 1e-6).ceil() as i32;
    reach.clamp(0, TAP_ZERO - 1)
}

/// The kernel for a goal in that direction (of length 1, in the map's axes); `None`: at the goal, where no direction is
/// better than another and the disc alone is left.
pub fn kernel(config: &Config, towards_goal: Option<DVec2>) -> Kernel {
    let cells = |metres: f64| metres / config.scan_resolution_m + EPSILON;
    let (length, disc) = (cells(config.inflation_length_m), cells(config.inflation_side_m));
    let inscribed = cells(config.inscribed_radius_m);
    let half_width = f64::from(config.inflation_padding_cells) + 0.5 + EPSILON;
    let on_line = |at: DVec2| {
        towards_goal.is_some_and(|goal| {
            let (along, across) = (at.dot(goal), at.perp_dot(goal).abs());
            let side = config.inflation_kernel == InflationKernel::Symmetric || along <= EPSILON;
            side && across <= half_width && at.abs().max_element() <= length
        })
    };
    let reach = reach_cells(config);
    let square = (-reach..=reach).flat_map(|y| (-reach..=reach).map(move |x| [x, y]));
    let place = |[x, y]: [i32; 2]| DVec2::new(x.into(), y.into());
    let chosen = square.filter(|&tap| {
        let at = place(tap);
        let line = match config.inflation_kernel {
            InflationKernel::Uniform => at.abs().max_element() <= length,
            InflationKernel::Adaptive | InflationKernel::Symmetric => on_line(at),
        };
        line || at.length() <= disc.max(inscribed)
    });
    let (mut taps, others): (Vec<_>, Vec<_>) = chosen.partition(|&tap| place(tap).length() <= inscribed);
    let inscribed = taps.len();
    taps.extend(others);
    Kernel { taps, inscribed }
}

impl Kernel {
    /// As the shader takes it.
    pub fn packed(&self) -> Vec<u32> {
        let byte = |value: i32| (value + TAP_ZERO).clamp(0, 255).cast_unsigned();
        self.taps.iter().map(|&[x, y]| byte(x) | (byte(y) << 8)).collect()
    }
}

/// The parameters for `kernel` in a window of `side` x `side` cells.
pub fn params(side: u32, kernel: &Kernel, [origin_slot_x, origin_slot_y]: [u32; 2]) -> GoalInflationParams {
    let count = |number: usize| u32::try_from(number).unwrap_or(0);
    let (taps, inscribed) = (count(kernel.taps.len()), count(kernel.inscribed));
    GoalInflationParams { side, taps, inscribed, origin_slot_x, origin_slot_y }
}

/// Declares `inflation` and `kernel_taps` and appends the pass over `verdicts`, with `solid_cells` where the map has `lidars`.
///
/// # Errors
/// From the plan.
pub fn declare(plan: &mut Plan, side: u32, config: &Config, lidars: bool) -> Result<()> {
    let edge = u64::from(2 * reach_cells(config).unsigned_abs() + 1);
    plan.uniform::<GoalInflationParams>("goal_inflation_params")?;
    plan.zeroed("inflation", u64::from(side) * u64::from(side) * 4)?;
    plan.upload("kernel_taps", 4 * edge * edge)?;
    let pass = if lidars { GOAL_INFLATION_OF_LIDARS } else { GOAL_INFLATION_OF_CAMERAS };
    plan.step(pass, Invocations::area(side, side), &[])
}

/// The stage.
#[derive(Debug)]
pub struct GoalInflation {
    /// What it is built for.
    pub map: Arc<MapJob>,
}

impl Stage for GoalInflation {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        declare(plan, self.map.side, &self.map.config, self.map.layers.lidars)
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let kernel = kernel(&self.map.config, moment.towards_goal);
        let origin_slot = moment.window.origin_slot(self.map.side);
        input.write("kernel_taps", bytemuck::cast_slice(&kernel.packed()))?;
        input.set("goal_inflation_params", &params(self.map.side, &kernel, origin_slot))
    }
}
