//! Live: what is played is what was recorded; a node's maps are those of a replay; and what a robot relies on when things fail.
//!
//! Nodes and peers are participants of the product itself on the loopback network. Where that network does not carry DDS,
//! the tests are left out by name.

mod client;
mod faults;
#[cfg(feature = "foxglove")]
mod foxglove;
mod lapses;
mod node;
mod peer;
mod play;
mod processes;
mod python;
mod robot;
mod services;
mod topics;
