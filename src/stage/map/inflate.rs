//! Nav2's inflation by an exact distance transform (spec 1 §3).

use std::sync::Arc;

use bytemuck::cast_slice;

use crate::base::Result;
use crate::config::Config;
use crate::gpu::{FrameInput, Invocations, Plan, ShaderSource};
use crate::stage::{MapJob, Moment, Stage};

/// Lethal cells to bits.
pub const PACK: ShaderSource = ShaderSource {
    name: "inflate/pack",
    parts: &[
        include_str!("../../../shaders/lib/verdict.wgsl"),
        include_str!("../../../shaders/inflate/pack.wgsl"),
    ],
};

/// Distances along rows.
pub const ROWS: ShaderSource =
    ShaderSource { name: "inflate/rows", parts: &[include_str!("../../../shaders/inflate/rows.wgsl")] };

/// Distances along columns, and costs over those of the verdicts.
pub const COLUMNS: ShaderSource = ShaderSource {
    name: "inflate/columns",
    parts: &[
        include_str!("../../../shaders/lib/verdict.wgsl"),
        include_str!("../../../shaders/lib/classes/none.wgsl"),
        include_str!("../../../shaders/inflate/columns.wgsl"),
    ],
};

/// The same, and the classes of the cells.
pub const COLUMNS_AND_CLASSES: ShaderSource = ShaderSource {
    name: "inflate/columns",
    parts: &[
        include_str!("../../../shaders/lib/scan.wgsl"),
        include_str!("../../../shaders/lib/verdict.wgsl"),
        include_str!("../../../shaders/lib/classes/kept.wgsl"),
        include_str!("../../../shaders/inflate/columns.wgsl"),
    ],
};

crate::params! {
    /// Parameters of `inflate/pack`.
    pub struct InflatePackParams {
        /// Cells along a side.
        pub side: u32,
        /// 32-bit words a row.
        pub words: u32,
    }
}

crate::params! {
    /// Parameters of `inflate/rows`.
    pub struct InflateRowsParams {
        /// Cells along a side.
        pub side: u32,
        /// 32-bit words a row.
        pub words: u32,
        /// Cells, at most 254.
        pub radius: u32,
        /// Words of four cells a row.
        pub quads: u32,
    }
}

crate::params! {
    /// Parameters of `inflate/columns`.
    pub struct InflateColumnsParams {
        /// Cells along a side.
        pub side: u32,
        /// Cells, at most 254.
        pub radius: u32,
        /// Words of four cells a row.
        pub quads: u32,
        /// Unused.
        pub pad: u32,
    }
}

/// Distances along rows are kept in bytes, one of which means "none".
pub const MAX_RADIUS_CELLS: u32 = 254;

/// Cells up to which costs reach: the radius rounded up as Nav2 does, but not for a rounding error.
pub fn radius_cells(config: &Config) -> u32 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates; then clamped")]
    let cells = (config.inflation_radius_m / config.resolution_m - 1e-6).ceil() as u32;
    cells.min(MAX_RADIUS_CELLS)
}

/// Nav2's cost at `distance_cells` between cell centres: 254 at 0, 253 up to the inscribed radius, then
/// `252 exp(-cost_scaling_factor (d - inscribed_radius))` truncated.
pub fn cost(config: &Config, distance_cells: f64) -> u32 {
    let distance_m = distance_cells * config.resolution_m;
    if distance_cells == 0.0 {
        return 254;
    }
    if distance_m <= config.inscribed_radius_m {
        return 253;
    }
    let falling = (-config.cost_scaling_factor * (distance_m - config.inscribed_radius_m)).exp();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in 0..=252")]
    let cost = (252.0 * falling) as u32;
    cost
}

/// Costs by squared distance in cells, up to the radius.
pub fn cost_table(config: &Config) -> Vec<u32> {
    let radius = radius_cells(config);
    (0..=radius * radius).map(|squared| cost(config, f64::from(squared).sqrt())).collect()
}

/// Parameters of the three passes.
pub type Params = (InflatePackParams, InflateRowsParams, InflateColumnsParams);

/// The parameters for a window of `side` x `side` cells, the same at every time.
pub fn params(side: u32, config: &Config) -> Params {
    let (words, quads, radius) = (side.div_ceil(32), side.div_ceil(4), radius_cells(config));
    (
        InflatePackParams { side, words },
        InflateRowsParams { side, words, radius, quads },
        InflateColumnsParams { side, radius, quads, pad: 0 },
    )
}

/// Declares the buffers of the inflation of `verdicts` and appends its passes; `costmap` holds the costs, four cells a word,
/// and where `classes` are wanted `cell_classes` holds them likewise.
///
/// # Errors
/// From the plan.
pub fn declare(plan: &mut Plan, side: u32, config: &Config, classes: bool) -> Result<()> {
    let (words, quads) = (side.div_ceil(32), side.div_ceil(4));
    plan.uniform::<InflatePackParams>("inflate_pack_params")?;
    plan.uniform::<InflateRowsParams>("inflate_rows_params")?;
    plan.uniform::<InflateColumnsParams>("inflate_columns_params")?;
    plan.scratch("occupied_bits", u64::from(side * words) * 4)?;
    plan.scratch("row_distance", u64::from(side * quads) * 4)?;
    plan.fixed("cost_by_squared_distance", cast_slice(&cost_table(config)).to_vec())?;
    plan.product("costmap", u64::from(side * quads) * 4)?;
    plan.step(PACK, Invocations::line(side * words), &[])?;
    plan.step(ROWS, Invocations::line(side * quads), &[])?;
    if classes {
        plan.product("cell_classes", u64::from(side * quads) * 4)?;
    }
    let columns = if classes { COLUMNS_AND_CLASSES } else { COLUMNS };
    plan.step(columns, Invocations::line(side * quads), &[])
}

/// The stage.
#[derive(Debug)]
pub struct Inflate {
    /// What it is built for.
    pub map: Arc<MapJob>,
}

impl Stage for Inflate {
    fn append(&self, plan: &mut Plan) -> Result<()> {
        declare(plan, self.map.side, &self.map.config, self.map.layers.lidars)
    }

    fn write(&self, _moment: &Moment<'_>, input: &mut FrameInput<'_>) -> Result<()> {
        let (pack, rows, columns) = params(self.map.side, &self.map.config);
        input.set("inflate_pack_params", &pack)?;
        input.set("inflate_rows_params", &rows)?;
        input.set("inflate_columns_params", &columns)
    }
}
