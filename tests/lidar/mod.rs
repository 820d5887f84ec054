//! The lidar path as a whole.

mod plan;
