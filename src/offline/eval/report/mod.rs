//! Results as text, JSON and one HTML page, the paper's figures beside ours.

mod html;
mod json;
pub mod paper;
mod scenes;
pub mod table;

use std::collections::BTreeMap;

pub(crate) use html::page;

use crate::offline::eval::SceneResult;
use crate::offline::eval::contest::is_frontier;
use crate::offline::eval::result::{LevelSummary, summarize};

/// An evaluation.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
    /// What was evaluated, in a line.
    pub title: String,
    /// By level.
    pub levels: BTreeMap<String, LevelSummary>,
    /// Scenes in their order, with the name of each one's picture where there is one.
    pub scenes: Vec<(String, Option<String>)>,
    /// Their results.
    pub results: Vec<SceneResult>,
}

/// Methods in the order of the tables; others follow.
const ORDER: [&str; 10] = [
    "naive",
    "range",
    "median",
    "temporal",
    "naive_3_hits",
    "drm",
    "drm_learned",
    "drm_evidence",
    "drm_weight",
    "drm_gate",
];

impl Report {
    /// Sums `results` up.
    pub fn new(title: &str, results: &[SceneResult]) -> Self {
        let scenes = results.iter().map(|result| (result.name.clone(), None));
        Self {
            title: title.into(),
            levels: summarize(results),
            scenes: scenes.collect(),
            results: results.to_vec(),
        }
    }
}

/// Methods of a level in the order of the tables, without points of the frontier.
fn ordered(level: &LevelSummary) -> Vec<&str> {
    let mut keys: Vec<&str> =
        level.methods.keys().map(String::as_str).filter(|key| !is_frontier(key)).collect();
    keys.sort_by_key(|key| ORDER.iter().position(|known| known == key).unwrap_or(ORDER.len()));
    keys
}
