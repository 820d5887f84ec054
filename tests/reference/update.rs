//! Occupancy, hysteresis, confirmations, temporal rejection of one cell (spec 1 §3, §4).

use limpid::config::{Config, Method};

/// What is published of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum State {
    #[default]
    Unknown,
    Free,
    Occupied,
}

/// What one frame says of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Observation {
    /// Hits, with the mean of their weights.
    Hit(f64),
    SeenThrough,
    Unseen,
}

/// A cell over time.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cell {
    pub(crate) p: f64,
    pub(crate) state: State,
    /// Whether each observed frame hit it, the newest last.
    history: Vec<bool>,
}

impl Cell {
    /// Takes one frame in; gives e, -1 where it says nothing.
    pub(crate) fn observe(&mut self, config: &Config, lambda: f64, seen: Observation) -> f64 {
        let e = match seen {
            Observation::Unseen => return -1.0,
            Observation::Hit(weight) => weight,
            Observation::SeenThrough => 0.0,
        };
        let hit = matches!(seen, Observation::Hit(_));
        self.history.push(hit);
        if hit && !self.may_mark(config) {
            return -1.0;
        }
        self.p = lambda * self.p + (1.0 - lambda) * e;
        let run = self.history.iter().rev().take_while(|hit| **hit).count();
        let enters = self.p >= config.occupied_threshold && run >= config.confirmations as usize;
        let stays = self.state == State::Occupied && self.p >= config.free_threshold;
        self.state = if enters || stays {
            State::Occupied
        } else if !hit && self.p < config.free_threshold {
            State::Free
        } else if self.state == State::Occupied {
            State::Unknown
        } else {
            self.state
        };
        e
    }

    fn may_mark(&self, config: &Config) -> bool {
        let recent = self.history.iter().rev().take(config.temporal_window as usize);
        config.method != Method::Temporal
            || recent.filter(|hit| **hit).count() >= config.temporal_hits as usize
    }
}
