//! What everything stands on: errors, rigid transforms, time.

mod error;
mod geometry;
mod plain;
mod refused;
mod time;

pub use error::{Error, Result};
pub use geometry::Rigid;
pub(crate) use geometry::single;
pub(crate) use plain::{nearest, plain};
pub use refused::Refused;
pub use time::{duration_ns, seconds_between};
