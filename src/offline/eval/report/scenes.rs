//! Scene by scene, the worst first; and the frontier between false obstacles and missed ones.

use crate::offline::eval::SceneResult;
use crate::offline::eval::contest::is_frontier;
use crate::offline::eval::report::table::{Table, number, pooled, strings};
use crate::offline::eval::report::{LevelSummary, Report};
use crate::offline::eval::result::{Figures, MethodTally};

const SCENES_NOTE: &str = "naive and drm; the worst first: by FOR and the recall that drm loses to naive; most of drm's wrong cells, as a \
share of the true obstacle cells";
const FRONTIER_NOTE: &str = "method drm with other values of a key of the configuration, pooled: the more obstacles are kept, the more false \
ones there are";

/// The figures of each scene.
const SHOWN: [&str; 4] = ["for", "fsr", "or", "or_near"];

/// FOR of drm, and the recall that it loses to naive.
fn badness(naive: &Figures, drm: &Figures) -> f64 {
    let of = |figures: &Figures, name| figures.get(name).copied().unwrap_or(0.0);
    of(drm, "for") + (of(naive, "or") - of(drm, "or")).max(0.0)
}

/// A scene's row, and how bad it is; `None` where one of both methods is missing.
fn row(scene: &SceneResult) -> Option<(f64, Vec<String>)> {
    let [naive, drm]: [&MethodTally; 2] = [scene.methods.get("naive")?, scene.methods.get("drm")?];
    let figures = [naive, drm].map(MethodTally::figures);
    let mut cells = vec![scene.level.clone(), scene.name.clone()];
    cells.extend(figures.iter().flat_map(|of| SHOWN.map(|name| number(of.get(name).copied(), 3))));
    cells.push(match drm.map.largest_loss() {
        Some((what, share)) => format!("{what} ({share:.2})"),
        None => "-".into(),
    });
    Some((badness(&figures[0], &figures[1]), cells))
}

impl Report {
    /// A row for each scene with both methods.
    pub(super) fn scenes_table(&self) -> Table {
        let mut rows: Vec<_> = self.results.iter().filter_map(row).collect();
        rows.sort_by(|(a, left), (b, right)| left[0].cmp(&right[0]).then(b.total_cmp(a)));
        let head = [
            "level",
            "scene",
            "naive FOR",
            "FSR",
            "OR",
            "near",
            "drm FOR",
            "FSR",
            "OR",
            "near",
            "drm's wrong cells",
        ];
        Table {
            title: "Scenes".into(),
            note: SCENES_NOTE.into(),
            head: strings(&head),
            rows: rows.into_iter().map(|(_, cells)| cells).collect(),
        }
    }

    /// A row for each point of the frontier and level; `None` where it was not asked for.
    pub(super) fn frontier_table(&self) -> Option<Table> {
        let of_level = |(name, level): (&String, &LevelSummary)| {
            let mut points: Vec<_> = level.methods.iter().filter(|(key, _)| is_frontier(key)).collect();
            // By the value behind the key.
            let value = |key: &str| key.rsplit(' ').next().and_then(|value| value.parse::<f64>().ok());
            points.sort_by(|(a, _), (b, _)| value(a).unwrap_or(0.0).total_cmp(&value(b).unwrap_or(0.0)));
            let as_configured = level.methods.get_key_value("drm").into_iter();
            let rows = points.into_iter().chain(as_configured).map(|(key, method)| {
                let label = if key == "drm" { "as configured" } else { key };
                let mut cells = vec![name.clone(), label.to_owned()];
                cells.extend(SHOWN.map(|figure| pooled(method, figure)));
                cells
            });
            rows.collect::<Vec<_>>()
        };
        let asked = self.levels.values().any(|level| level.methods.keys().any(|key| is_frontier(key)));
        asked.then(|| Table {
            title: "Frontier".into(),
            note: FRONTIER_NOTE.into(),
            head: strings(&["level", "key", "FOR", "FSR", "OR", "OR near"]),
            rows: self.levels.iter().flat_map(of_level).collect(),
        })
    }
}
