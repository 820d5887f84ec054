//! Writers: what they wrote, read back by other code than theirs.

mod dump;
mod map_server;
mod mcap;
mod pictures;
mod room;
mod unwritable;
