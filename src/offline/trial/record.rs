//! What is kept of a trial.

use serde::{Deserialize, Serialize};

use super::world::Outline;
use crate::offline::eval::MapTally;

/// How a trial ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "end", rename_all = "snake_case")]
pub enum Outcome {
    /// Within 0.3 m of the goal in time.
    Arrived,
    /// The footprint met a true obstacle.
    Collision {
        /// Its key in the scene.
        with: String,
    },
    /// No progress of 0.1 m in 15 s.
    Frozen,
    /// Four times the ideal time was over.
    Timeout,
    /// The map was stale, and the robot stood.
    Halted {
        /// Way from the sensor's last data to the stand, metres.
        way_m: f64,
        /// Time from the sensor's last data to the stand, seconds.
        after_s: f64,
    },
    /// The task cannot be done: this trial counts for nothing.
    Impossible {
        /// Why.
        reason: String,
    },
}

impl Outcome {
    /// In a word or two.
    pub fn name(&self) -> String {
        match self {
            Self::Arrived => "arrived".into(),
            Self::Collision { with } => format!("collision with {with}"),
            Self::Frozen => "frozen".into(),
            Self::Timeout => "timeout".into(),
            Self::Halted { after_s, .. } => format!("halted after {after_s:.1} s"),
            Self::Impossible { reason } => format!("impossible: {reason}"),
        }
    }
}

/// A step of the controller.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Since the start, seconds.
    pub t_s: f64,
    /// True place and heading: metres, metres, radians.
    pub pose: [f64; 3],
    /// Forward and turning velocity.
    pub speed: [f64; 2],
}

/// Something that happened: `stop`, `clear`, `spin`, `wait`, `back up`, `stale`, `collision`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// Since the start, seconds.
    pub t_s: f64,
    /// What.
    pub what: String,
}

/// A grid as runs of letters: `f12u40l3` are 12 free cells, 40 unknown, 3 lethal; row 0 = smallest y.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// Since the start, seconds.
    pub t_s: f64,
    /// Corner of the first cell, metres.
    pub origin_m: [f64; 2],
    /// Metres.
    pub cell_m: f64,
    /// Cells along x.
    pub width: u32,
    /// The cells.
    pub runs: String,
    /// The path that the robot had, corners, metres.
    pub path: Vec<[f64; 2]>,
}

/// Letters of costs: free, graded, inscribed, lethal, unknown.
pub fn letter_of_cost(cost: u8) -> char {
    match cost {
        0 => 'f',
        1..=252 => 'g',
        253 => 'i',
        254 => 'l',
        255 => 'u',
    }
}

/// Letters of true cells ([`crate::sim::truth`]).
pub fn letter_of_truth(cell: i8) -> char {
    match cell {
        crate::sim::truth::FREE => 'f',
        crate::sim::truth::OCCUPIED => 'l',
        crate::sim::truth::GLASS => 'w',
        crate::sim::truth::PASSABLE => 'p',
        _ => 'u',
    }
}

/// Runs of equal letters, each with its length.
pub fn runs(letters: impl Iterator<Item = char>) -> String {
    let (mut text, mut last) = (String::new(), None);
    for letter in letters {
        match &mut last {
            Some((before, count)) if *before == letter => *count += 1,
            _ => {
                push(&mut text, last);
                last = Some((letter, 1));
            }
        }
    }
    push(&mut text, last);
    text
}

fn push(text: &mut String, run: Option<(char, u32)>) {
    if let Some((letter, count)) = run {
        text.push(letter);
        text.push_str(&count.to_string());
    }
}

/// Pixels of depth against the truth.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Depth {
    /// Share without depth.
    pub holes: f64,
    /// Share of the valid pixels that are wrong by more than a tenth.
    pub spikes: f64,
}

/// A trial.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Scenario, by its name.
    pub scenario: String,
    /// Glare level.
    pub level: String,
    /// Method.
    pub method: String,
    /// Seed of world and task.
    pub seed: u64,
    /// Fingerprint of the settings that it was made with; empty where it was made alone.
    #[serde(default)]
    pub settings: String,
    /// The scene's name.
    pub scene: String,
    /// How it ended.
    pub outcome: Outcome,
    /// From the goal's arrival to the end, seconds.
    pub time_s: f64,
    /// Way driven, metres.
    pub driven_m: f64,
    /// From the end of the way to the goal, metres.
    pub left_m: f64,
    /// The shortest way on the true map, metres.
    pub ideal_m: f64,
    /// Emergency stops.
    pub stops: u32,
    /// Recoveries begun.
    pub recoveries: usize,
    /// The map against the truth, twice a second.
    pub map: MapTally,
    /// Cells by class against the truth, at the end.
    pub classes: super::classes::ClassTally,
    /// The camera's depth, twice a second; `None` without a camera.
    pub depth: Option<Depth>,
    /// Seconds of computing.
    pub wall_s: f64,
    /// Start, goal.
    pub task: [[f64; 2]; 2],
    /// The shortest way, corners.
    pub ideal: Vec<[f64; 2]>,
    /// Every step.
    pub steps: Vec<Step>,
    /// What happened.
    pub events: Vec<Event>,
    /// What stands in the world.
    pub outlines: Vec<Outline>,
    /// The true map.
    pub truth: Option<Picture>,
    /// The map as the robot had it, once a second.
    pub pictures: Vec<Picture>,
}

impl Record {
    /// What tables are made of: the last step alone, and no maps and outlines.
    pub fn figures(&self) -> Self {
        Self {
            steps: self.steps.last().copied().into_iter().collect(),
            outlines: Vec::new(),
            truth: None,
            pictures: Vec::new(),
            ..self.clone()
        }
    }

    /// Whether there is more than [`Self::figures`]: something to draw.
    pub fn has_drive(&self) -> bool {
        !self.pictures.is_empty() || !self.outlines.is_empty()
    }

    /// Whether it counts, and how: `None` for a task that cannot be done. To halt is what a robot without sensors is to do.
    pub fn success(&self) -> Option<bool> {
        match self.outcome {
            Outcome::Impossible { .. } => None,
            Outcome::Arrived | Outcome::Halted { .. } => Some(true),
            _ => Some(false),
        }
    }

    /// Way driven over the shortest one, of a trial that arrived; what is left to the goal counts as driven.
    pub fn ratio(&self) -> Option<f64> {
        let arrived = self.outcome == Outcome::Arrived && self.ideal_m > 0.0;
        arrived.then(|| (self.driven_m + self.left_m) / self.ideal_m)
    }

    /// In a line.
    pub fn line(&self) -> String {
        let Self { scenario, level, method, seed, time_s, driven_m, ideal_m, stops, wall_s, .. } = self;
        let figures = [
            ("ratio", self.ratio()),
            ("FOR", self.map.false_occupied_rate(1)),
            ("FSR", self.map.free_space_recall(1)),
            ("OR", self.map.obstacle_recall()),
            ("F", self.classes.f_score()),
        ];
        let figures: String =
            figures.into_iter().filter_map(|(name, value)| Some(format!(", {name} {:.3}", value?))).collect();
        format!(
            "{scenario} {level} {method} seed {seed}: {} in {time_s:.1} s, {driven_m:.2} m of {ideal_m:.2} m, {stops} stops{figures} ({wall_s:.0} s)",
            self.outcome.name()
        )
    }
}
