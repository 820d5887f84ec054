//! One test binary: truth first (analytic scenes, other programs), then plain scalar twins.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking, in its helpers too")]
#![allow(clippy::cast_possible_truncation, reason = "test data are small and known")]

mod allocation;
mod cameras;
mod cells;
mod cli;
mod cli_drm;
mod cli_frames;
mod cli_info;
mod cli_outputs;
mod config;
mod eval;
mod glass;
mod golden;
mod ground;
mod lidar;
#[cfg(feature = "ros2")]
mod live;
mod map;
mod network;
mod one_hall;
mod one_map;
mod plan;
mod read;
mod readme;
mod real;
mod reference;
mod shaders;
mod sim;
mod stage;
mod support;
mod targets;
mod training;
mod trial;
mod weights;
mod write;
