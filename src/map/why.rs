//! Why a cell has its cost: what the rule decided, and what each layer of the map says (spec 4 §4).

use crate::map::rule::{ROWS, Row, RuleSettings, rows};
use crate::map::{CellClass, Clock, Verdict};

/// What the map holds of one cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Why {
    /// Centre of the cell in the map, metres.
    pub at_m: [f64; 2],
    /// From the robot's base to there, metres.
    pub range_m: f64,
    /// Nav2 cost after inflation.
    pub cost: u8,
    /// What the rule decided, before inflation.
    pub verdict: Verdict,
    /// What the cameras say; `None`: the map has none, or none has seen the cell.
    pub camera: Option<CameraSays>,
    /// What the lidars say.
    pub lidar: Option<LidarSays>,
    /// The pane that crosses the cell.
    pub pane: Option<PaneSays>,
    /// Where the ground drops away.
    pub drop: Option<DropSays>,
}

/// What the occupancy layer holds of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraSays {
    /// Occupied, free, or neither.
    pub state: Occupancy,
    /// p of spec 1 §3; with fusion evidence the share of the evidence that is for the cell.
    pub occupancy: f32,
    /// With fusion evidence what is for the cell, and what against it (A and B of spec 1 §9).
    pub evidence: Option<[f32; 2]>,
    /// Lowest and highest hit above the ground, metres; `None`: no hit is remembered.
    pub hits_m: Option<[f64; 2]>,
    /// Mean R of the last hit.
    pub reliability: f64,
    /// Who saw it last, and how long ago.
    pub by: SeenBy,
}

/// State of a cell of the occupancy layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Occupancy {
    /// Neither.
    Unknown,
    /// Seen through.
    Free,
    /// In the way.
    Occupied,
}

/// What the solidity layer holds of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LidarSays {
    /// Class of the cell.
    pub class: CellClass,
    /// Between which heights above the ground beams crossed, and the largest gap between two of them, metres; `None`: not kept.
    pub crossed_m: Option<[f64; 3]>,
    /// Who saw it last, and how long ago.
    pub by: SeenBy,
}

/// What the layer of panes holds of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaneSays {
    /// Number of the pane.
    pub pane: u32,
    /// Who found it last, and how long ago.
    pub by: SeenBy,
}

/// What the layer of drops holds of a cell that is one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DropSays {
    /// How far below the ground the sensor saw something through the cell, metres.
    pub depth_m: f64,
    /// Who saw it last, and how long ago.
    pub by: SeenBy,
}

/// A sensor, and the time since its evidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenBy {
    /// Its number among the map's sensors; `None`: not kept.
    pub sensor: Option<usize>,
    /// Seconds.
    pub age_s: f64,
}

/// The records of a cell as the GPU keeps them; `None` for layers that the map lacks.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Records {
    pub(crate) cell: Option<[u32; 4]>,
    pub(crate) marks: Option<[u32; 2]>,
    pub(crate) solid: Option<[u32; 4]>,
    pub(crate) pane: Option<[u32; 2]>,
    pub(crate) drop: Option<[u32; 4]>,
}

/// Steps of the heights in records a metre (`shaders/lib/record.wgsl`).
const RECORD_STEPS_PER_M: f64 = 1024.0;

/// Heights of crossing beams count from this far below the ground, metres (the same).
const CROSSING_ZERO_M: f64 = 32.0;

/// Steps of the highest hit a metre, and the number from which they count (`shaders/lib/cell.wgsl`).
const HEIGHT_STEPS_PER_M: f64 = 65536.0;
const FLOOR: u32 = 1;

/// Bit of a cell that drops (`shaders/lib/drops/drops.wgsl`).
const DROPS: u32 = 1;

fn seen_by(word: u32, tick: u32, now: u32) -> SeenBy {
    let sensor = usize::try_from((word >> 24) & 0x1f).ok().and_then(|number| number.checked_sub(1));
    SeenBy { sensor, age_s: f64::from(now.saturating_sub(tick)) * Clock::TICK_S }
}

impl Records {
    /// What the cameras' records say; `height_min_m`: lower edge of the height band; `evidence`: cells hold evidence for and against.
    pub(crate) fn camera(&self, now: u32, height_min_m: f64, evidence: bool) -> Option<CameraSays> {
        let ([first, state, third, top], [tick, marks]) = (self.cell?, self.marks?);
        let [support, opposed] = [first, third].map(f32::from_bits);
        if tick == 0 {
            return None;
        }
        let low_m = height_min_m + f64::from(marks & 0xffff) / RECORD_STEPS_PER_M;
        let high_m = |top: u32| height_min_m + f64::from(top - FLOOR - 1) / HEIGHT_STEPS_PER_M;
        Some(CameraSays {
            state: match state & 3 {
                1 => Occupancy::Free,
                2 => Occupancy::Occupied,
                _ => Occupancy::Unknown,
            },
            occupancy: match evidence {
                true if support + opposed > 0.0 => support / (support + opposed),
                true => 0.0,
                false => support,
            },
            evidence: evidence.then_some([support, opposed]),
            hits_m: (top > FLOOR).then(|| [low_m.min(high_m(top)), high_m(top)]),
            reliability: f64::from((marks >> 16) & 0xff) / 255.0,
            by: seen_by(marks, tick, now),
        })
    }

    /// What the lidars' records say.
    pub(crate) fn lidar(&self, now: u32) -> Option<LidarSays> {
        let [class, tick, heights, gap] = self.solid?;
        if tick == 0 {
            return None;
        }
        let height_m = |steps: u32| f64::from(steps) / RECORD_STEPS_PER_M - CROSSING_ZERO_M;
        let class = CellClass::ALL.into_iter().find(|&of| of as u32 == class & 0xff);
        Some(LidarSays {
            class: class.unwrap_or(CellClass::Unknown),
            crossed_m: (heights != 0).then(|| {
                let gap_m = f64::from(gap & 0xffff) / RECORD_STEPS_PER_M;
                [height_m(heights & 0xffff), height_m(heights >> 16), gap_m]
            }),
            by: seen_by(gap, tick, now),
        })
    }

    /// What the record of panes says.
    pub(crate) fn pane(&self, now: u32) -> Option<PaneSays> {
        let [pane, tick] = self.pane?;
        (tick != 0).then(|| PaneSays { pane: pane & 0x00ff_ffff, by: seen_by(pane, tick, now) })
    }

    /// What the record of drops says.
    pub(crate) fn drop(&self, now: u32) -> Option<DropSays> {
        let [_, tick, flags, depth] = self.drop?;
        let depth_m = f64::from(depth) / RECORD_STEPS_PER_M;
        (flags & DROPS != 0).then(|| DropSays { depth_m, by: seen_by(flags, tick, now) })
    }
}

impl Why {
    /// The row of the rule that applied; `None` where none was asked.
    pub fn row(&self, settings: &RuleSettings) -> Option<Row> {
        let index = usize::try_from(self.verdict.row()).ok()?.checked_sub(1)?;
        rows(settings).get(index).copied().filter(|_| index < ROWS.len())
    }

    /// In words: the cost, the verdict and its evidence; then what each layer says, a line each, that of drops where there is one. `names`: of the sensors.
    pub fn text(&self, settings: &RuleSettings, names: &[String]) -> String {
        let mut lines = vec![self.sentence(settings, names)];
        lines.push(match &self.camera {
            None => "  cameras: nothing".into(),
            Some(says) => format!("  cameras: {}", says.text(names)),
        });
        lines.push(match &self.lidar {
            None => "  lidars: nothing".into(),
            Some(says) => format!("  lidars: {}", says.text(names)),
        });
        lines.push(match &self.pane {
            None => "  panes: none".into(),
            Some(says) => format!("  panes: pane {}, found {}", says.pane, says.by.text(names)),
        });
        lines.extend(self.drop.map(|says| {
            format!("  drops: {:.2} m below the ground, seen {}", says.depth_m, says.by.text(names))
        }));
        lines.join("\n")
    }

    fn sentence(&self, settings: &RuleSettings, names: &[String]) -> String {
        let (name, number) = match self.row(settings) {
            Some(row) => (row.name, row.number),
            None => ("unknown", 0),
        };
        let spread = match (self.cost, self.verdict.cost()) {
            (cost, base) if cost == base => String::new(),
            (253, _) => "within the inscribed radius of a lethal cell; itself ".into(),
            _ => "near a lethal cell; itself ".into(),
        };
        let pane = match (&self.pane, number) {
            (Some(says), 1) => format!(", pane {}", says.pane),
            _ => String::new(),
        };
        let by = match self.verdict.sensor() {
            Some(sensor) => {
                let by = SeenBy { sensor: Some(sensor), age_s: self.verdict.age_s() };
                format!(", seen {} at {:.1} m", by.text(names), self.range_m)
            }
            None => String::new(),
        };
        let camera = match (&self.camera, number) {
            (Some(says), 1..=3) if says.state != Occupancy::Occupied => "; the camera sees through it",
            _ => "",
        };
        let rule = if number == 0 { String::new() } else { format!(" (row {number} of the rule)") };
        format!("{}: {spread}{name}{pane}{by}{camera}{rule}", self.cost)
    }
}

impl SeenBy {
    fn text(&self, names: &[String]) -> String {
        let name = self.sensor.and_then(|sensor| names.get(sensor)).map_or("a sensor", String::as_str);
        format!("by {name} {:.1} s ago", self.age_s)
    }
}

impl CameraSays {
    fn text(&self, names: &[String]) -> String {
        let state = match self.state {
            Occupancy::Unknown => "unknown",
            Occupancy::Free => "free",
            Occupancy::Occupied => "occupied",
        };
        let hits = match self.hits_m {
            Some([low, high]) if self.state == Occupancy::Occupied => {
                format!(", hit {low:.2} to {high:.2} m above the ground, mean R {:.2}", self.reliability)
            }
            _ => String::new(),
        };
        let by = match self.evidence {
            Some([support, opposed]) => format!("{support:.2} for, {opposed:.2} against"),
            None => format!("p {:.2}", self.occupancy),
        };
        format!("{state} ({by}){hits}, seen {}", self.by.text(names))
    }
}

impl LidarSays {
    fn text(&self, names: &[String]) -> String {
        let crossed = match self.crossed_m {
            Some([low, high, gap]) => {
                format!(
                    ", beams crossed from {low:.2} to {high:.2} m above the ground, at most {gap:.2} m apart"
                )
            }
            None => String::new(),
        };
        format!("{}{crossed}, seen {}", self.class.name(), self.by.text(names))
    }
}
