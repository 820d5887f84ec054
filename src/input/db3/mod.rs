//! SQLite bags of rosbag2 (`.db3`): tables `topics` and `messages`.

#[cfg(not(feature = "db3"))]
mod absent;
#[cfg(feature = "db3")]
mod database;
#[cfg(feature = "db3")]
mod records;
#[cfg(feature = "db3")]
mod unpacked;

#[cfg(not(feature = "db3"))]
pub(in crate::input) use crate::input::db3::absent::{Db3Records, Unpacked};
#[cfg(feature = "db3")]
pub(in crate::input) use crate::input::db3::records::Db3Records;
#[cfg(feature = "db3")]
pub(in crate::input) use crate::input::db3::unpacked::Unpacked;

/// First bytes of an SQLite file.
pub(in crate::input) const MAGIC: &[u8] = b"SQLite format 3\0";
