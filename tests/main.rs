//! One test binary: truth first (analytic scenes, other programs), then plain scalar twins.

#![allow(clippy::cast_possible_truncation, reason = "test data are small and known")]

mod map;
mod reference;
mod stage;
mod support;
