//! A test file per stage: truth, twin, edge sizes, poison.

mod align_color;
mod back_project;
mod drm;
mod glass;
mod glass_labels;
mod glass_search;
mod goal_costs;
mod goal_inflation;
mod inflate;
mod ingest;
mod intensity_classes;
mod intensity_layers;
mod move_window;
mod pane_cells;
mod plan_map;
mod register_color;
mod rule;
mod see_through;
mod solid_cells;
mod spatial_median;
mod tally;
mod targets;
mod trajectory_cost;
mod update;
mod view;
mod weigh;
