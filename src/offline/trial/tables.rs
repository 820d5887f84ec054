//! Tables V, VI and I as our trials have them, the papers' figures beside.

use serde_json::{Value, json};

use super::classes::ClassTally;
use super::paper;
use super::record::{Outcome, Record};
use crate::offline::eval::MapTally;
use crate::offline::eval::report::table::Table;
use crate::offline::eval::result::Spread;

/// A ratio above this is a detour (spec 7 §2).
const DETOUR: f64 = 1.2;

const MAP_NOTE: &str = "over the drive, twice a second, one-cell tolerance, pooled (mean +- deviation over trials); holes and spikes: of the camera's depth; OR: obstacle recall before \
inflation; paper: Table V";
const DRIVE_NOTE: &str = "n: trials whose task can be done; success: arrived, or halted where the sensors died; stops: emergency stops per 10 m driven; ratio: way over the shortest one on the true map, detours: share with a \
ratio over 1.2, time: to the goal, these three of the n that arrived (mean +- deviation); paper: Table VI";
const LIDAR_NOTE: &str = "n, success and length as above; F: over solid, passable and transparent cells of the last map, pooled, one-cell tolerance, then by class; paper: Table I";

/// Trials with what follows from them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
    /// In the order in which they were made.
    pub records: Vec<Record>,
}

/// The trials of one setting.
pub struct Group<'a> {
    /// Scenario, level and method.
    pub key: [&'a str; 3],
    /// Trials that count.
    pub records: Vec<&'a Record>,
}

impl Group<'_> {
    fn arrived(&self) -> impl Iterator<Item = &Record> {
        self.records.iter().copied().filter(|record| record.outcome == Outcome::Arrived)
    }

    fn count(&self, is: impl Fn(&Outcome) -> bool) -> usize {
        self.records.iter().filter(|record| is(&record.outcome)).count()
    }

    /// Percent of the trials.
    fn success(&self) -> Option<f64> {
        let done = self.records.iter().filter(|record| record.success() == Some(true)).count();
        share(done, self.records.len())
    }

    fn collisions(&self) -> usize {
        self.count(|outcome| matches!(outcome, Outcome::Collision { .. }))
    }

    fn stops(&self) -> Option<Spread> {
        let rate = |record: &&Record| f64::from(record.stops) * 10.0 / record.driven_m.max(1.0);
        Spread::of(&self.records.iter().map(rate).collect::<Vec<_>>())
    }

    fn ratio(&self) -> Option<Spread> {
        Spread::of(&self.arrived().filter_map(Record::ratio).collect::<Vec<_>>())
    }

    fn detours(&self) -> Option<f64> {
        let ratios: Vec<f64> = self.arrived().filter_map(Record::ratio).collect();
        share(ratios.iter().filter(|ratio| **ratio > DETOUR).count(), ratios.len())
    }

    fn time(&self) -> Option<Spread> {
        Spread::of(&self.arrived().map(|record| record.time_s).collect::<Vec<_>>())
    }

    /// A figure of the maps: pooled, then over trials.
    fn map(&self, figure: impl Fn(&MapTally) -> Option<f64>) -> (Option<f64>, Option<Spread>) {
        let mut pooled = MapTally::default();
        self.records.iter().for_each(|record| pooled.add(&record.map));
        let each: Vec<f64> = self.records.iter().filter_map(|record| figure(&record.map)).collect();
        (figure(&pooled), Spread::of(&each))
    }

    fn depth(&self, pick: impl Fn(&super::record::Depth) -> f64) -> Option<f64> {
        let values: Vec<f64> =
            self.records.iter().filter_map(|record| record.depth.as_ref().map(&pick)).collect();
        Spread::of(&values).map(|spread| spread.mean)
    }

    fn classes(&self) -> ClassTally {
        let mut all = ClassTally::default();
        self.records.iter().for_each(|record| all.add(&record.classes));
        all
    }

    fn json(&self) -> Value {
        let spread = |spread: Option<Spread>| spread.map(|s| json!([s.mean, s.deviation]));
        let pooled = |figure: fn(&MapTally) -> Option<f64>| self.map(figure).0;
        let [scenario, level, method] = self.key;
        json!({
            "scenario": scenario, "level": level, "method": method,
            "seeds": self.records.iter().map(|record| record.seed).collect::<Vec<_>>(),
            "trials": self.records.len(), "arrived": self.arrived().count(), "collisions": self.collisions(),
            "frozen": self.count(|outcome| *outcome == Outcome::Frozen), "timeouts": self.count(|outcome| *outcome == Outcome::Timeout),
            "stops_per_10_m": spread(self.stops()), "ratio": spread(self.ratio()), "detours_percent": self.detours(),
            "time_s": spread(self.time()), "f_score": self.classes().f_score(),
            "for": pooled(|m| m.false_occupied_rate(1)), "fsr": pooled(|m| m.free_space_recall(1)), "or": pooled(MapTally::obstacle_recall),
            "holes": self.depth(|d| d.holes), "spikes": self.depth(|d| d.spikes),
        })
    }
}

/// Percent; `None` of nothing.
#[expect(clippy::cast_precision_loss, reason = "counts of trials")]
fn share(part: usize, whole: usize) -> Option<f64> {
    (whole > 0).then(|| 100.0 * part as f64 / whole as f64)
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".into(), |value| format!("{value:.digits$}"))
}

fn spread(value: Option<Spread>, digits: usize) -> String {
    value.map_or_else(|| "-".into(), |s| format!("{:.digits$} +- {:.digits$}", s.mean, s.deviation))
}

fn both((pooled, over): (Option<f64>, Option<Spread>)) -> String {
    let beside = over.map_or_else(String::new, |s| format!(" ({:.3} +- {:.3})", s.mean, s.deviation));
    number(pooled, 3) + &beside
}

fn strings(cells: &[&str]) -> Vec<String> {
    cells.iter().map(|&cell| cell.to_owned()).collect()
}

impl Report {
    /// Settings in the order in which they came, with the trials that count.
    pub fn groups(&self) -> Vec<Group<'_>> {
        let mut groups: Vec<Group<'_>> = Vec::new();
        for record in self.records.iter().filter(|record| record.success().is_some()) {
            let key = [record.scenario.as_str(), record.level.as_str(), record.method.as_str()];
            match groups.iter_mut().find(|group| group.key == key) {
                Some(group) => group.records.push(record),
                None => groups.push(Group { key, records: vec![record] }),
            }
        }
        groups.sort_by_key(|group| (group.key[0].to_owned(), group.key[1].to_owned()));
        groups
    }

    /// Those that there are trials for.
    pub fn tables(&self) -> Vec<Table> {
        let groups = self.groups();
        let (lidar, camera): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|group| group.records.iter().all(|record| record.depth.is_none()));
        let tables = [map_table(&camera), drive_table(&camera), lidar_table(&lidar), self.failures()];
        tables.into_iter().filter(|table| !table.rows.is_empty()).collect()
    }

    /// Trials that did not arrive, and tasks that cannot be done.
    fn failures(&self) -> Table {
        let row = |record: &Record| {
            let at = record.steps.last().map_or_else(String::new, |step| {
                format!("({:.1}, {:.1}) after {:.1} m", step.pose[0], step.pose[1], record.driven_m)
            });
            let Record { scenario, level, method, seed, outcome, .. } = record;
            vec![format!("{scenario} {level}"), method.clone(), seed.to_string(), outcome.name(), at]
        };
        Table {
            title: "Trials that did not arrive".into(),
            note: "places in metres".into(),
            head: strings(&["setting", "method", "seed", "end", "where"]),
            rows: self.records.iter().filter(|record| record.success() != Some(true)).map(row).collect(),
        }
    }

    /// All tables as text.
    pub fn text(&self) -> String {
        self.tables()
            .iter()
            .map(|table| format!("\n{}: {}\n{}", table.title, table.note, table.text()))
            .collect()
    }

    /// Figures by setting, and those of each trial ([`Record::figures`]).
    pub fn json(&self) -> Value {
        let trials: Vec<Record> = self.records.iter().map(Record::figures).collect();
        json!({ "settings": self.groups().iter().map(Group::json).collect::<Vec<_>>(), "trials": trials })
    }
}

fn setting(group: &Group<'_>) -> String {
    format!("{} {}", group.key[0], group.key[1])
}

fn map_table(groups: &[Group<'_>]) -> Table {
    let row = |group: &Group<'_>| {
        let paper = crate::offline::eval::report::paper::find(group.key[1], group.key[2])
            .filter(|_| group.key[0] == "glare");
        let [a, b] = [0, 1].map(|i| number(paper.map(|row| row.map[i]), 3));
        let (holes, spikes) = (group.depth(|d| d.holes), group.depth(|d| d.spikes));
        let mut cells = vec![setting(group), group.key[2].into(), group.records.len().to_string()];
        cells.extend([number(holes, 3), number(spikes, 3)]);
        cells.push(both(group.map(|map| map.false_occupied_rate(1))));
        cells.push(both(group.map(|map| map.free_space_recall(1))));
        cells.push(both(group.map(MapTally::obstacle_recall)));
        cells.extend([a, b]);
        cells
    };
    Table {
        title: "Maps".into(),
        note: MAP_NOTE.into(),
        head: strings(&["setting", "method", "n", "holes", "spikes", "FOR", "FSR", "OR", "paper FOR", "FSR"]),
        rows: groups.iter().map(row).collect(),
    }
}

fn drive_table(groups: &[Group<'_>]) -> Table {
    let row = |group: &Group<'_>| {
        let paper = paper::drive_of(group.key[1], group.key[2]).filter(|_| group.key[0] == "glare");
        let way = paper.and_then(|row| row.way);
        let mut cells = vec![setting(group), group.key[2].into(), group.records.len().to_string()];
        cells.push(number(group.success(), 1));
        cells.push(group.collisions().to_string());
        cells.push(group.count(|outcome| *outcome == Outcome::Frozen).to_string());
        cells.push(group.count(|outcome| *outcome == Outcome::Timeout).to_string());
        cells.push(spread(group.stops(), 2));
        cells.extend([spread(group.ratio(), 2), number(group.detours(), 0), spread(group.time(), 1)]);
        cells.extend([number(paper.map(|row| row.success), 1), number(paper.map(|row| row.stops), 2)]);
        cells.extend([0, 1, 2].map(|i| number(way.map(|way| way[i]), [2, 0, 1][i])));
        cells
    };
    Table {
        title: "Drives".into(),
        note: DRIVE_NOTE.into(),
        head: strings(&[
            "setting",
            "method",
            "n",
            "success %",
            "collisions",
            "frozen",
            "timeouts",
            "stops / 10 m",
            "ratio",
            "detours %",
            "time s",
            "paper success",
            "stops",
            "ratio",
            "detours",
            "time",
        ]),
        rows: groups.iter().map(row).collect(),
    }
}

fn lidar_table(groups: &[Group<'_>]) -> Table {
    let row = |group: &Group<'_>| {
        let paper = paper::lidar_of(group.key[0], group.key[2]);
        let classes = group.classes();
        let mut cells = vec![setting(group), group.key[2].into(), group.records.len().to_string()];
        cells.push(number(group.success(), 0));
        cells.push(group.collisions().to_string());
        cells.push(group.count(|outcome| *outcome == Outcome::Frozen).to_string());
        cells.push(group.count(|outcome| *outcome == Outcome::Timeout).to_string());
        cells.extend([spread(group.ratio(), 3), number(classes.f_score(), 2)]);
        let by_class = [classes.solid, classes.passable, classes.transparent];
        cells.extend(by_class.map(|counts| number(counts.f_score(), 2)));
        cells.push(number(paper.map(|row| row.2), 0));
        cells.extend([number(paper.and_then(|row| row.3), 3), number(paper.and_then(|row| row.4), 2)]);
        cells
    };
    Table {
        title: "Lidars".into(),
        note: LIDAR_NOTE.into(),
        head: strings(&[
            "setting",
            "method",
            "n",
            "success %",
            "collisions",
            "frozen",
            "timeouts",
            "length",
            "F",
            "F solid",
            "passable",
            "transparent",
            "paper success",
            "length",
            "F",
        ]),
        rows: groups.iter().map(row).collect(),
    }
}
