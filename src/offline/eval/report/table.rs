//! The report's tables, as rows of cells: text in columns, or HTML.

use crate::offline::eval::report::{LevelSummary, Report, ordered, paper};
use crate::offline::eval::result::MethodSummary;

/// A table with a title, a note and rows of equal length.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// What it shows.
    pub title: String,
    /// What its columns mean.
    pub note: String,
    /// Column heads.
    pub head: Vec<String>,
    /// Cells.
    pub rows: Vec<Vec<String>>,
}

const SENSOR_NOTE: &str = "over the pixels that the method trusts (others are holes to it); given up: share of the measured \
pixels that it does not trust; paper: Table IV";
const MAP_NOTE: &str = "one-cell tolerance, pooled (mean +- deviation over scenes); strict: without tolerance; OR: obstacle \
recall before inflation, near: a lethal neighbour counts; paper: Table V";
const PIXEL_NOTE: &str = "\"unreliable\" (further from the truth than delta) among measured pixels; F1 at tau, and at the best \
threshold; a method without a network has reliability 1 or 0";

pub(super) fn strings(cells: &[&str]) -> Vec<String> {
    cells.iter().map(|&cell| cell.to_owned()).collect()
}

pub(super) fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".into(), |value| format!("{value:.digits$}"))
}

pub(super) fn pooled(method: &MethodSummary, name: &str) -> String {
    number(method.pooled.get(name).copied(), 3)
}

/// Pooled, then mean and deviation over scenes.
fn spread(method: &MethodSummary, name: &str) -> String {
    let spread = method.scenes.get(name);
    let beside = spread.map_or_else(String::new, |s| format!(" ({:.3} +- {:.3})", s.mean, s.deviation));
    pooled(method, name) + &beside
}

impl Report {
    /// Sensor level, map level, the frontier where it was asked for, scenes and reliability, in this order.
    pub fn tables(&self) -> Vec<Table> {
        let first = [self.sensor_table(), self.map_table()].into_iter().chain(self.frontier_table());
        first.chain([self.scenes_table(), self.pixel_table()]).collect()
    }

    /// Each method of each level.
    fn rows(&self, row: impl Fn(&str, &str, &MethodSummary) -> Vec<String>) -> Vec<Vec<String>> {
        let of_level = |(name, level): (&String, &LevelSummary)| {
            let methods = ordered(level).into_iter().filter_map(|key| Some((key, level.methods.get(key)?)));
            methods.map(|(key, method)| row(name, key, method)).collect::<Vec<_>>()
        };
        self.levels.iter().flat_map(of_level).collect()
    }

    fn sensor_table(&self) -> Table {
        let row = |level: &str, key: &str, method: &MethodSummary| {
            let [holes, spikes, rmse, given_up] =
                ["hole_rate", "spike_rate", "rmse_m", "given_up"].map(|name| pooled(method, name));
            let paper = paper::find(level, key).and_then(|row| row.sensor);
            let [a, b, c] = [0, 1, 2].map(|i| number(paper.map(|values| values[i]), 3));
            vec![level.into(), key.into(), holes, spikes, rmse, given_up, a, b, c]
        };
        Table {
            title: "Depth".into(),
            note: SENSOR_NOTE.into(),
            head: strings(&[
                "level",
                "method",
                "holes",
                "spikes",
                "RMSE m",
                "given up",
                "paper holes",
                "spikes",
                "RMSE m",
            ]),
            rows: self.rows(row),
        }
    }

    fn map_table(&self) -> Table {
        let row = |level: &str, key: &str, method: &MethodSummary| {
            let paper = paper::find(level, key).map(|row| row.map);
            let [a, b] = [0, 1].map(|i| number(paper.map(|values| values[i]), 3));
            let mut cells = vec![level.into(), key.into()];
            cells.extend(["for", "fsr", "or"].map(|name| spread(method, name)));
            cells
                .extend(["or_near", "or_glass", "for_strict", "fsr_strict"].map(|name| pooled(method, name)));
            cells.extend([a, b]);
            cells
        };
        Table {
            title: "Costmap".into(),
            note: MAP_NOTE.into(),
            head: strings(&[
                "level",
                "method",
                "FOR",
                "FSR",
                "OR",
                "OR near",
                "OR glass",
                "FOR strict",
                "FSR strict",
                "paper FOR",
                "FSR",
            ]),
            rows: self.rows(row),
        }
    }

    fn pixel_table(&self) -> Table {
        let mut rows = Vec::new();
        for (name, level) in &self.levels {
            for key in ordered(level).into_iter().filter(|key| ["range", "drm"].contains(key)) {
                let Some(method) = level.methods.get(key) else { continue };
                let mut cells = vec![name.clone(), format!("reliability of {key}")];
                cells.extend(["unreliable_rate", "auprc", "f1", "f1_best"].map(|n| pooled(method, n)));
                rows.push(cells);
            }
            for (key, figures) in &level.predictors {
                let [auprc, best] = ["auprc", "f1_best"].map(|n| number(figures.get(n).copied(), 3));
                rows.push(vec![name.clone(), key.clone(), String::new(), auprc, String::new(), best]);
            }
        }
        Table {
            title: "Reliability".into(),
            note: PIXEL_NOTE.into(),
            head: strings(&["level", "score", "unreliable", "AUPRC", "F1 at tau", "best F1"]),
            rows,
        }
    }

    /// The tables as text.
    pub fn text(&self) -> String {
        let mut text = self.title.clone() + "\n";
        for (name, level) in &self.levels {
            text += &format!("{name}: {} scenes, {} frames scored\n", level.scenes, level.frames);
        }
        for table in self.tables() {
            text += &format!("\n{}: {}\n{}", table.title, table.note, table.text());
        }
        text
    }
}

impl Table {
    /// As a Markdown table with aligned columns.
    pub fn text(&self) -> String {
        let lines = || std::iter::once(&self.head).chain(&self.rows);
        let width = |column: usize| lines().filter_map(|row| row.get(column)).map(String::len).max();
        let widths: Vec<usize> = (0..self.head.len()).map(|column| width(column).unwrap_or(0)).collect();
        let line = |row: &Vec<String>| {
            let cells = row.iter().zip(&widths).map(|(cell, width)| format!(" {cell:width$} |"));
            format!("|{}\n", cells.collect::<String>())
        };
        let rule: String = widths.iter().map(|width| format!("{}|", "-".repeat(width + 2))).collect();
        let body: String = self.rows.iter().map(line).collect();
        format!("{}|{rule}\n{body}", line(&self.head))
    }
}
