//! Costs of trajectories on a plan map (spec 2 §5).

use glam::Vec2;

use crate::gpu::ShaderSource;

/// Candidate velocities to places.
pub const ROLL_OUT: ShaderSource = ShaderSource {
    name: "trajectory_cost/roll_out",
    parts: &[include_str!("../../../shaders/trajectory_cost/roll_out.wgsl")],
};

/// Places to costs.
pub const SUM: ShaderSource = ShaderSource {
    name: "trajectory_cost/sum",
    parts: &[include_str!("../../../shaders/trajectory_cost/sum.wgsl")],
};

crate::params! {
    /// Parameters of `trajectory_cost/roll_out`.
    pub struct RollOutParams {
        /// The robot in the window.
        pub start: Vec2,
        /// Radians from the window's x.
        pub heading: f32,
        /// Time from one place to the next.
        pub step_s: f32,
        /// Candidates.
        pub candidates: u32,
        /// Places of each.
        pub places: u32,
    }
}

crate::params! {
    /// Parameters of `trajectory_cost/sum`.
    pub struct SumParams {
        /// Cells along a side.
        pub side: u32,
        /// Words of four cells a row.
        pub quads: u32,
        /// Side of a cell.
        pub resolution_m: f32,
        /// Candidates.
        pub candidates: u32,
        /// Places of each.
        pub places: u32,
        /// Cost of a cell that is unknown or outside of the map.
        pub unknown_cost: u32,
    }
}
