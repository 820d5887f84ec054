//! The stages of a lidar scan (spec 2).

pub mod intensity_classes;
pub mod intensity_layers;
mod placed;
pub mod planes;
pub mod solidity;
pub mod trust;

pub use placed::{Placed, Turn};
