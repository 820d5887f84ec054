//! ROS 2 over DDS without a ROS install: names, qualities of service, messages as bytes. What is computed is elsewhere.

mod announce;
mod environment;
mod graph;
mod inbox;
mod name;
mod participant;
mod qos;
mod raw;
mod service;
mod vigil;

pub use announce::Announcement;
pub use environment::Environment;
pub use graph::{Graph, GraphTopic};
pub use inbox::{Counts, Inbox, Parcel};
pub use name::{Naming, type_of_dds};
pub use participant::{Participant, Publication, Subscription, Taken};
pub use qos::Quality;
pub use rustdds::bytes::Bytes;
pub use service::{Asker, Origin, Replies};

use crate::base::Error;

/// An [`Error::Ros2`] that concerns `what`.
fn ros2_error(what: impl Into<String>, reason: impl ToString) -> Error {
    Error::Ros2 { what: what.into(), reason: reason.to_string() }
}
