//! The stages of a lidar scan (spec 2).

pub mod intensity_classes;
pub mod intensity_layers;
pub mod planes;
pub mod solid_cells;
