//! Recovery as Nav2's default behaviour tree does it: clear the map, spin, wait, back up, in turns (spec 7 §1).

use glam::DVec2;

use super::robot::{Robot, Speed};
use crate::map::MapUpdate;

/// How long nothing must be free before the next one begins, seconds.
const PATIENCE_S: f64 = 1.0;

/// Nav2's defaults: angle and speed of the spin, wait, way and speed of backing up.
const SPIN_RAD: f64 = 1.57;
const SPIN_RAD_S: f64 = 1.0;
const WAIT_S: f64 = 5.0;
const BACK_M: f64 = 0.3;
const BACK_M_S: f64 = 0.15;

/// A lethal cell this near behind the footprint ends backing up, metres.
const BEHIND_M: f64 = 0.1;

/// What is done in turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Act {
    /// The map begins anew.
    Clear,
    /// A quarter turn on the spot.
    Spin,
    /// Stand.
    Wait,
    /// A little backwards.
    BackUp,
}

impl Act {
    const IN_TURN: [Self; 4] = [Self::Clear, Self::Spin, Self::Wait, Self::BackUp];

    /// Its name in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clear => "clear",
            Self::Spin => "spin",
            Self::Wait => "wait",
            Self::BackUp => "back up",
        }
    }

    fn lasts_s(self) -> f64 {
        match self {
            Self::Clear => 0.0,
            Self::Spin => SPIN_RAD / SPIN_RAD_S,
            Self::Wait => WAIT_S,
            Self::BackUp => BACK_M / BACK_M_S,
        }
    }
}

/// Where recovery stands.
#[derive(Debug, Clone, Default)]
pub struct Recovery {
    blocked_s: f64,
    begun: usize,
    acting: Option<(Act, f64)>,
}

impl Recovery {
    /// Counts a step in which nothing was free; an act that begins now.
    pub fn blocked(&mut self, time_s: f64) -> Option<Act> {
        self.blocked_s += time_s;
        if self.blocked_s < PATIENCE_S {
            return None;
        }
        self.blocked_s = 0.0;
        let act = Act::IN_TURN[self.begun % Act::IN_TURN.len()];
        self.begun += 1;
        self.acting = Some((act, act.lasts_s()));
        Some(act)
    }

    /// Counts a step that was free.
    pub fn free(&mut self) {
        self.blocked_s = 0.0;
    }

    /// The speed of what is under way; `None` where nothing is.
    pub fn speed(&mut self, robot: &Robot, map: &MapUpdate, time_s: f64) -> Option<Speed> {
        let (act, left_s) = self.acting.filter(|(_, left_s)| *left_s > 0.0)?;
        self.acting = Some((act, left_s - time_s));
        Some(match act {
            Act::Clear | Act::Wait => Speed::default(),
            Act::Spin => Speed { v: 0.0, omega: SPIN_RAD_S },
            Act::BackUp if is_blocked_behind(map, robot) => {
                self.acting = None;
                Speed::default()
            }
            Act::BackUp => Speed { v: -BACK_M_S, omega: 0.0 },
        })
    }

    /// How many were begun.
    pub fn begun(&self) -> usize {
        self.begun
    }
}

/// Whether a lethal cell lies right behind the footprint.
fn is_blocked_behind(map: &MapUpdate, robot: &Robot) -> bool {
    let (pose, radius_m) = (robot.believed, robot.limits.radius_m);
    let back = -DVec2::from_angle(pose.yaw);
    let lethal = |x: u32, y: u32| map.costmap.get((y * map.grid.width + x) as usize) == Some(&254);
    let is_near = |x: u32, y: u32| {
        let off = DVec2::from_array(map.grid.centre_m(x, y)) - pose.at;
        let along = off.dot(back);
        along > 0.0 && along < radius_m + BEHIND_M && off.perp_dot(back).abs() < radius_m
    };
    let reach = DVec2::splat(radius_m + BEHIND_M);
    let (low, high) = (pose.at - reach, pose.at + reach);
    let corner = |at: DVec2| map.grid.cell_at(at.x, at.y);
    let (Some([x0, y0]), Some([x1, y1])) = (corner(low), corner(high)) else { return false };
    (y0..=y1).any(|y| (x0..=x1).any(|x| lethal(x, y) && is_near(x, y)))
}
