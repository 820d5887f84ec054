//! Plain scalar twins of the stages, written from the specification.

pub(crate) mod align_color;
pub(crate) mod back_project;
pub(crate) mod drm;
pub(crate) mod glass;
pub(crate) mod goal_costs;
pub(crate) mod goal_inflation;
pub(crate) mod inflate;
pub(crate) mod ingest;
pub(crate) mod intensity_classes;
pub(crate) mod intensity_layers;
pub(crate) mod move_window;
pub(crate) mod network;
pub(crate) mod pane_cells;
pub(crate) mod plan_map;
pub(crate) mod register_color;
pub(crate) mod rule;
pub(crate) mod see_through;
pub(crate) mod sim;
pub(crate) mod solid_cells;
pub(crate) mod spatial_median;
pub(crate) mod tally;
pub(crate) mod targets;
pub(crate) mod trajectory_cost;
pub(crate) mod update;
pub(crate) mod weigh;
