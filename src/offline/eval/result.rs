//! What a scene gave, as counts that add up, and the figures that follow from them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::offline::eval::{Decision, DepthTally, MapTally, Ranking};

/// Figures by name; one that is not defined (a share of nothing) is left out.
pub type Figures = BTreeMap<&'static str, f64>;

/// Counts of one method.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MethodTally {
    /// Depth of the pixels that it trusts.
    pub depth: DepthTally,
    /// Its costmaps.
    pub map: MapTally,
    /// Its reliability as a score for unreliable pixels among the measured ones.
    pub ranking: Ranking,
    /// The same, decided at tau.
    pub decision: Decision,
}

impl MethodTally {
    /// Adds the counts of another scene.
    pub fn add(&mut self, other: &Self) {
        self.depth.add(&other.depth);
        self.map.add(&other.map);
        self.ranking.add(&other.ranking);
        self.decision.add(&other.decision);
    }

    /// All figures, named as in the JSON report.
    pub fn figures(&self) -> Figures {
        let (depth, map) = (&self.depth, &self.map);
        let all = [
            ("hole_rate", depth.hole_rate()),
            ("spike_rate", depth.spike_rate()),
            ("rmse_m", depth.rmse_m()),
            ("given_up", depth.given_up_share()),
            ("for", map.false_occupied_rate(1)),
            ("fsr", map.free_space_recall(1)),
            ("for_strict", map.false_occupied_rate(0)),
            ("fsr_strict", map.free_space_recall(0)),
            ("for_ring", map.false_occupied_rate(2)),
            ("fsr_ring", map.free_space_recall(2)),
            ("or", map.obstacle_recall()),
            ("or_near", map.near_obstacle_recall()),
            ("or_glass", map.glass_recall()),
            ("unreliable_rate", self.ranking.base_rate()),
            ("auprc", self.ranking.auprc()),
            ("f1", self.decision.f1()),
            ("f1_best", self.ranking.best_f1()),
        ];
        all.into_iter().filter_map(|(name, value)| Some((name, value?))).collect()
    }
}

/// Counts of one scene or recording.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneResult {
    /// Its name.
    pub name: String,
    /// Its glare level, or another group that it is pooled in.
    pub level: String,
    /// Frames scored.
    pub frames: u64,
    /// By method.
    pub methods: BTreeMap<String, MethodTally>,
    /// By cheap predictor: its score for unreliable pixels among the measured ones.
    pub predictors: BTreeMap<String, Ranking>,
}

/// A figure over scenes: mean and standard deviation (of the sample; 0 for one scene).
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Mean over scenes.
    pub mean: f64,
    /// Standard deviation over scenes.
    pub deviation: f64,
}

impl Spread {
    /// Of the figures of single scenes; `None` without any.
    pub fn of(values: &[f64]) -> Option<Self> {
        #[expect(clippy::cast_precision_loss, reason = "scenes fit in 53 bits")]
        let count = values.len() as f64;
        if values.is_empty() {
            return None;
        }
        let mean = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        Some(Self { mean, deviation: (squares / (count - 1.0).max(1.0)).sqrt() })
    }
}

/// A method over all scenes of a level.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MethodSummary {
    /// Figures of the pooled counts.
    pub pooled: Figures,
    /// The same figures, scene by scene.
    pub scenes: BTreeMap<&'static str, Spread>,
}

/// All scenes of a level.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LevelSummary {
    /// Scenes.
    pub scenes: usize,
    /// Frames scored.
    pub frames: u64,
    /// By method.
    pub methods: BTreeMap<String, MethodSummary>,
    /// AUPRC and best F1 of the cheap predictors, pooled.
    pub predictors: BTreeMap<String, Figures>,
}

/// Figures by level.
pub fn summarize(results: &[SceneResult]) -> BTreeMap<String, LevelSummary> {
    let mut levels: BTreeMap<String, Vec<&SceneResult>> = BTreeMap::new();
    for result in results {
        levels.entry(result.level.clone()).or_default().push(result);
    }
    levels.into_iter().map(|(level, scenes)| (level, of_level(&scenes))).collect()
}

fn of_level(scenes: &[&SceneResult]) -> LevelSummary {
    let mut level = LevelSummary { scenes: scenes.len(), ..LevelSummary::default() };
    let mut predictors: BTreeMap<String, Ranking> = BTreeMap::new();
    let mut methods: BTreeMap<String, (MethodTally, Vec<Figures>)> = BTreeMap::new();
    for scene in scenes {
        level.frames += scene.frames;
        for (key, ranking) in &scene.predictors {
            predictors.entry(key.clone()).or_default().add(ranking);
        }
        for (key, tally) in &scene.methods {
            let (pooled, figures) = methods.entry(key.clone()).or_default();
            pooled.add(tally);
            figures.push(tally.figures());
        }
    }
    let ranked = |ranking: &Ranking| -> Figures {
        let figures = [("auprc", ranking.auprc()), ("f1_best", ranking.best_f1())];
        figures.into_iter().filter_map(|(name, value)| Some((name, value?))).collect()
    };
    level.predictors = predictors.iter().map(|(key, ranking)| (key.clone(), ranked(ranking))).collect();
    let summary = |(pooled, figures): (MethodTally, Vec<Figures>)| {
        let pooled = pooled.figures();
        let values = |name: &str| figures.iter().filter_map(|f| f.get(name).copied()).collect::<Vec<_>>();
        let scenes = pooled.keys().filter_map(|&name| Some((name, Spread::of(&values(name))?))).collect();
        MethodSummary { pooled, scenes }
    };
    level.methods = methods.into_iter().map(|(key, method)| (key, summary(method))).collect();
    level
}
