//! One test binary: truth first (analytic scenes, other programs), then plain scalar twins.

#![allow(clippy::cast_possible_truncation, reason = "test data are small and known")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

mod config;
mod read;
mod stage;
mod support;
mod write;
