#![doc = include_str!("../README.md")]

pub mod bench;
pub mod camera;
pub mod config;
pub mod error;
pub mod eval;
pub mod frame;
pub mod geometry;
pub mod glass;
pub mod gpu;
pub mod lidar;
pub mod network;
pub mod pipeline;
mod receive;
pub mod recording;
pub mod run;
pub mod sim;
pub mod stage;
pub mod targets;
pub mod weights;

pub use config::Config;
pub use error::{Error, Result};
