#![doc = include_str!("../README.md")]

pub mod base;
pub mod config;
pub mod frame;
pub mod gpu;
pub mod input;
pub mod lidar;
pub mod map;
pub mod message;
pub mod network;
pub mod offline;
pub mod output;
pub mod pipeline;
mod receive;
pub mod run;
pub mod sensor;
pub mod sim;
pub mod stage;

pub use base::{Error, Result};
pub use config::Config;
