//! One self-contained page: the tables, and drives from above that play step by step.

use serde_json::json;

use super::record::{Record, Step};
use super::tables::Report;
use crate::offline::eval::report::table::Table;

const PAGE: &str = include_str!("replay.html");

/// The page of a report.
pub fn page(report: &Report) -> String {
    let trials: Vec<serde_json::Value> =
        report.records.iter().filter(|record| record.has_drive()).map(trial).collect();
    // A `<` in a text could end the script.
    let data = serde_json::Value::from(trials).to_string().replace('<', "\\u003c");
    let tables: String = report.tables().iter().map(Table::html).collect();
    PAGE.replace("<!--TABLES-->", &tables).replace("/*DATA*/[]", &data)
}

fn trial(record: &Record) -> serde_json::Value {
    let Record { scenario, level, method, seed, .. } = record;
    json!({
        "name": format!("{scenario} {level} seed {seed}: {method}, {}", record.outcome.name()),
        "said": record.line(),
        "task": record.task,
        "ideal": record.ideal,
        "steps": record.steps.iter().map(step).collect::<Vec<_>>(),
        "events": record.events,
        "outlines": record.outlines,
        "truth": record.truth,
        "pictures": record.pictures,
    })
}

/// Time, place and heading, to a millimetre.
fn step(step: &Step) -> [f64; 4] {
    let [x, y, yaw] = step.pose;
    [step.t_s, x, y, yaw].map(|number| (number * 1e3).round() / 1e3)
}
