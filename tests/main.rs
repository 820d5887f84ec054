//! One test binary: truth first (analytic scenes, other programs), then plain scalar twins.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on must fail")]

mod support;
mod write;
