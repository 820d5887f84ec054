//! On a robot: recordings played into a ROS 2 graph, and the map of what a graph's sensors see.

mod building;
mod clouds;
mod finding;
mod full_names;
mod health;
mod mapping;
mod node;
mod outputs;
mod parameters;
mod play;
mod publisher;
mod reading;
#[cfg(feature = "foxglove")]
mod served;
mod services;
mod sheet;
mod stop;
mod supervisor;
mod timeline;
mod trial;

pub use node::{NodeOptions, run_node};
pub use play::{PlayOptions, PlayReport, play};
pub use stop::Stop;
pub use trial::{Trial, try_node};
