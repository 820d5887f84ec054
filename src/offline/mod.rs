//! Tools that work on recordings: evaluation, training samples, benchmarks, labels and scores of single scans and maps.

pub mod bench;
pub mod cells;
pub mod eval;
pub mod labeller;
pub mod score;
pub mod solidity;
pub mod targets;
pub mod trial;
