//! Messages as they lie in recordings: bytes in, values out, no I/O.

pub mod foxglove;
pub mod lidar;
pub mod live;
pub(crate) mod marker;
pub mod ros1;
pub mod ros2;
pub(crate) mod schema;
pub mod service;
pub mod written;

pub use written::RosMessage;

use crate::base::Error;

/// An [`Error::Decode`] that concerns `what`.
pub(crate) fn decode_error(what: impl Into<String>, reason: impl Into<String>) -> Error {
    Error::Decode { what: what.into(), reason: reason.into() }
}

/// A frame's name without the leading slashes that ROS 1 and some drivers write.
pub(crate) fn bare_frame(frame: String) -> String {
    match bare_name(&frame) {
        bare if bare.len() < frame.len() => bare.into(),
        _ => frame,
    }
}

/// As [`bare_frame`].
pub(crate) fn bare_name(frame: &str) -> &str {
    frame.trim_start_matches('/')
}
