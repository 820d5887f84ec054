//! The report as JSON: `levels.L2.drm.for` and so on.

use serde_json::{Map, Value, json};

use crate::offline::eval::report::Report;
use crate::offline::eval::result::{LevelSummary, MethodSummary};

impl Report {
    /// `levels.LEVEL.METHOD.FIGURE` pooled, `.over_scenes.FIGURE` with `mean` and `deviation`; `levels.LEVEL.scenes` and
    /// `.frames`; `levels.LEVEL.predictors.NAME`.
    pub fn json(&self) -> Value {
        let levels: Map<String, Value> =
            self.levels.iter().map(|(name, level)| (name.clone(), of_level(level))).collect();
        json!({ "title": self.title, "levels": levels })
    }
}

fn of_level(level: &LevelSummary) -> Value {
    let mut object = Map::new();
    object.insert("scenes".into(), json!(level.scenes));
    object.insert("frames".into(), json!(level.frames));
    object.insert("predictors".into(), json!(level.predictors));
    for (key, method) in &level.methods {
        object.insert(key.clone(), of_method(method));
    }
    object.into()
}

fn of_method(method: &MethodSummary) -> Value {
    let mut object: Map<String, Value> =
        method.pooled.iter().map(|(&name, &value)| (name.into(), json!(value))).collect();
    object.insert("over_scenes".into(), json!(method.scenes));
    object.into()
}
