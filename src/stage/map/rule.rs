//! The verdict of every cell of the window (spec 4 §2 to §4): the rule of [`crate::map::rule`] over the layers that the map has.

use std::sync::Arc;

use glam::UVec4;

use crate::base::Result;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderText};
use crate::map::Clock;
use crate::map::rule::{RuleSettings, rule_wgsl};
use crate::stage::map::layers::Layers;
use crate::stage::{MapJob, Moment, Stage, single};

/// Sensors that a map may have, at most.
pub const MOST_SENSORS: usize = 16;

crate::params! {
    /// Parameters of `rule`.
    pub struct RuleParams {
        /// By sensor + 1, four to a vector: the tick before which its evidence is stale.
        pub fresh_since: [UVec4; 5],
        /// Cells along a side.
        pub side: u32,
        /// Slot of window cell (0, 0) along x.
        pub origin_slot_x: u32,
        /// Slot of window cell (0, 0) along y.
        pub origin_slot_y: u32,
        /// The newest tick.
        pub now: u32,
        /// Ticks after which any evidence is stale; 0: never.
        pub cell_timeout: u32,
        /// Lower edge of the height band above the ground, metres.
        pub height_min_m: f32,
        /// Unused.
        pub pad0: u32,
        /// Unused.
        pub pad1: u32,
    }
}

/// What the parameters of one verdict are made of.
#[derive(Debug, Clone, Copy)]
pub struct RuleMoment<'a> {
    /// Cells along a side of the window.
    pub side: u32,
    /// Slot of window cell (0, 0).
    pub origin_slot: [u32; 2],
    /// The newest tick.
    pub now: u32,
    /// Of each sensor the tick before which its evidence is stale: 0 never, `u32::MAX` for a stale sensor. At most
    /// [`MOST_SENSORS`].
    pub fresh_since: &'a [u32],
    /// Ticks after which any evidence is stale; 0: never.
    pub cell_timeout: u32,
    /// Lower edge of the height band above the ground, metres.
    pub height_min_m: f32,
}

/// The parameters.
pub fn params(moment: &RuleMoment<'_>) -> RuleParams {
    let mut fresh_since = [[0; 4]; 5];
    let of_sensors = fresh_since.iter_mut().flatten().skip(1);
    of_sensors.zip(moment.fresh_since.iter().take(MOST_SENSORS)).for_each(|(to, from)| *to = *from);
    let [origin_slot_x, origin_slot_y] = moment.origin_slot;
    RuleParams {
        fresh_since: fresh_since.map(UVec4::from_array),
        side: moment.side,
        origin_slot_x,
        origin_slot_y,
        now: moment.now,
        cell_timeout: moment.cell_timeout,
        height_min_m: moment.height_min_m,
        pad0: 0,
        pad1: 0,
    }
}

/// The files of the pass over those layers, before and after the rule's own text.
pub fn parts(layers: Layers) -> [&'static str; 9] {
    [
        include_str!("../../../shaders/lib/cell.wgsl"),
        include_str!("../../../shaders/lib/slot.wgsl"),
        include_str!("../../../shaders/lib/record.wgsl"),
        include_str!("../../../shaders/lib/verdict.wgsl"),
        if layers.cameras {
            include_str!("../../../shaders/lib/rule/cameras.wgsl")
        } else {
            include_str!("../../../shaders/lib/rule/no_cameras.wgsl")
        },
        if layers.lidars {
            include_str!("../../../shaders/lib/rule/lidars.wgsl")
        } else {
            include_str!("../../../shaders/lib/rule/no_lidars.wgsl")
        },
        if layers.panes {
            include_str!("../../../shaders/lib/rule/panes.wgsl")
        } else {
            include_str!("../../../shaders/lib/rule/no_panes.wgsl")
        },
        if layers.drops {
            include_str!("../../../shaders/lib/rule/drops.wgsl")
        } else {
            include_str!("../../../shaders/lib/rule/no_drops.wgsl")
        },
        include_str!("../../../shaders/rule.wgsl"),
    ]
}

/// The lookup of `fresh_since` for a map of so many sensors, by constant places: places that vary from cell to cell are slow on
/// software drivers.
fn fresh_since_wgsl(sensors: usize) -> String {
    let place = |number: usize| format!("rule_params.fresh_since[{}][{}]", number / 4, number % 4);
    let of = |number: usize| format!("    since = select(since, {}, sensor == {number}u);\n", place(number));
    let lines: String = (1..=sensors.min(MOST_SENSORS)).map(of).collect();
    format!("fn fresh_since_of(sensor: u32) -> u32 {{\n    var since = 0u;\n{lines}    return since;\n}}\n")
}

/// The pass, for a map of so many `sensors`.
pub fn shader(layers: Layers, settings: &RuleSettings, sensors: usize) -> ShaderText {
    let says = [layers.panes, layers.lidars, layers.cameras];
    let alone = format!("const ALONE = {};", sensors == 1);
    let texts = [rule_wgsl(settings, says), alone, parts(layers).join("\n"), fresh_since_wgsl(sensors)];
    let text = texts.join("\n");
    ShaderText { label: "rule".into(), entry_point: "rule", text }
}

/// Declares the layers, `rule_params` and `verdicts`, and appends the pass.
///
/// # Errors
/// From the plan.
pub fn declare(
    plan: &mut Plan,
    side: u32,
    layers: Layers,
    settings: &RuleSettings,
    sensors: usize,
) -> Result<()> {
    layers.declare(plan, side)?;
    plan.uniform::<RuleParams>("rule_params")?;
    plan.product("verdicts", u64::from(side) * u64::from(side) * 4)?;
    plan.step(shader(layers, settings, sensors), Invocations::area(side, side), &[])
}

/// The stage.
#[derive(Debug)]
pub struct Rule {
    /// What it is built for.
    pub map: Arc<MapJob>,
}

impl Stage for Rule {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        declare(plan, self.map.side, self.map.layers, &RuleSettings::of(&self.map.config), self.map.sensors)
    }

    fn write(&self, moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let (side, config) = (self.map.side, &self.map.config);
        let params = params(&RuleMoment {
            side,
            origin_slot: moment.window.origin_slot(side),
            now: moment.now,
            fresh_since: moment.fresh_since,
            cell_timeout: Clock::ticks(config.cell_timeout_s),
            height_min_m: single(config.height_min_m),
        });
        input.set("rule_params", &params)
    }
}
