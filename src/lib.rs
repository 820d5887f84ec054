#![doc = include_str!("../README.md")]

pub mod config;
pub mod input;
pub mod map;
pub mod output;
pub mod run;
pub mod sensor;

// Public for the command, the tests and the benchmarks alone: not part of what limpid promises.
#[doc(hidden)]
pub mod base;
#[doc(hidden)]
pub mod gpu;
#[cfg(feature = "ros2")]
#[doc(hidden)]
pub mod live;
#[doc(hidden)]
pub mod mapper;
#[doc(hidden)]
pub mod message;
#[doc(hidden)]
pub mod network;
#[doc(hidden)]
pub mod offline;
#[cfg(feature = "ros2")]
#[doc(hidden)]
pub mod ros2;
#[doc(hidden)]
pub mod sim;
#[doc(hidden)]
pub mod stage;

#[doc(inline)]
pub use {
    base::{Error, Refused, Result},
    config::{Config, SensorInfo},
    input::{Source, open_source},
    map::{MapUpdate, State, Update, Verdict},
    mapper::{Mapper, Options, Submitted},
    output::Sink,
    run::{RunReport, run},
    sensor::Observation,
};
