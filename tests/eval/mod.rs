//! Evaluation: hand-computed counts, scikit-learn's figures, scenes and pairs end to end.

mod command;
mod contest;
mod depth;
mod glass_scenes;
mod map;
mod pairs;
mod ranking;
mod report;
