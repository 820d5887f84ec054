//! One test binary: truth first (analytic scenes, other programs), then plain scalar twins.

mod read;
mod support;
