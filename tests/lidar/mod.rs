//! The lidar path as a whole.

mod bad_input;
mod command;
mod field;
mod glass;
mod numpy;
mod plan;
mod poses;
mod recordings;
mod score;
mod solidity;
mod trust;
