//! The stages of the map: its window, its inflation, its costs.

pub mod bridge;
pub mod goal_costs;
pub mod goal_inflation;
pub mod inflate;
pub mod layers;
pub mod move_window;
pub mod rule;
pub mod scan_values;
pub mod trajectory_cost;
