#![doc = include_str!("../README.md")]

pub mod base;
pub mod config;
pub mod gpu;
pub mod input;
pub mod map;
pub mod mapper;
pub mod message;
pub mod network;
pub mod offline;
pub mod output;
pub mod run;
pub mod sensor;
pub mod sim;
pub mod stage;

pub use base::{Error, Result};
pub use config::Config;
