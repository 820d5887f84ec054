//! The controller: the dynamic window approach on limpid's scorer, and a turn on the spot towards the path (spec 7 §1).

use glam::DVec2;

use super::robot::{Pose, Robot, Speed};
use super::route::ahead;
use crate::base::Result;
use crate::gpu::Context;
use crate::map::MapUpdate;
use crate::offline::score::Scorer;

/// Samples of either velocity.
const FORWARD_SAMPLES: u32 = 7;
const TURN_SAMPLES: u32 = 15;

/// Times that a velocity is held for, seconds: the shorter one where nothing is free so far.
const HORIZONS_S: [f64; 2] = [1.5, 0.7];

/// How far ahead on the path the robot aims, metres.
const AIM_M: f64 = 0.8;

/// Angle off the path from which it turns on the spot (Nav2's rotation shim: 0.785), and down to which it does, radians.
const TURN_FROM_RAD: f64 = 0.785;
const TURN_TO_RAD: f64 = 0.2;

/// Cost of a cell that the robot's centre must not be in.
const INSCRIBED: u32 = 253;

/// Weights of the way's end off the aim (1/m), of its heading off the aim's (1/rad), and of the mean cost on it (1/252).
const AIM_WEIGHT: f64 = 2.0;
const HEADING_WEIGHT: f64 = 0.4;
const COST_WEIGHT: f64 = 0.8;

/// What the controller says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    /// Move so.
    Go(Speed),
    /// No velocity is free.
    Blocked,
}

/// See the module.
pub struct Controller {
    scorer: Scorer,
    is_turning: bool,
}

impl Controller {
    /// For maps of that many cells a side.
    ///
    /// # Errors
    /// Those of [`Scorer::on`].
    pub fn new(context: &Context, side: u32, resolution_m: f64, robot: &Robot) -> Result<Self> {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some dozens")]
        let places = (2.0 * robot.limits.speed_m_s * HORIZONS_S[0] / resolution_m).ceil() as u32 + 2;
        let scorer = Scorer::on(context, side, FORWARD_SAMPLES * TURN_SAMPLES, places)?;
        Ok(Self { scorer, is_turning: false })
    }

    /// The next speed along `path`, for `time_s`.
    ///
    /// # Errors
    /// Those of [`Scorer::score_velocities`].
    pub fn command(
        &mut self,
        map: &MapUpdate,
        robot: &Robot,
        path: &[DVec2],
        time_s: f64,
    ) -> Result<Command> {
        let pose = robot.believed;
        let Some(aim) = ahead(path, pose.at, AIM_M) else { return Ok(Command::Blocked) };
        let bearing = pose.bearing(aim);
        let bound = if self.is_turning { TURN_TO_RAD } else { TURN_FROM_RAD };
        self.is_turning = bearing.abs() > bound && pose.at.distance(aim) > 0.1;
        if self.is_turning {
            return Ok(Command::Go(turn(robot, bearing)));
        }
        let candidates = window(robot, path, time_s);
        for horizon_s in HORIZONS_S {
            let velocities: Vec<[f64; 2]> = candidates.iter().map(|speed| [speed.v, speed.omega]).collect();
            let scores = self.scorer.score_velocities(map, pose.rigid(), &velocities, horizon_s)?;
            let best = candidates
                .iter()
                .zip(&scores)
                .filter(|(_, score)| score.worst < INSCRIBED)
                .map(|(speed, score)| {
                    let known = score.cells - score.unknown;
                    let cost =
                        f64::from(score.cost - 255 * score.unknown) / (252.0 * f64::from(known.max(1)));
                    (AIM_WEIGHT * off_aim(pose.after(*speed, horizon_s), aim) + COST_WEIGHT * cost, speed)
                })
                .min_by(|(a, _), (b, _)| a.total_cmp(b));
            if let Some((_, speed)) = best {
                return Ok(Command::Go(*speed));
            }
        }
        Ok(Command::Blocked)
    }
}

/// How far a way's end is off the aim: metres, and heading as metres.
fn off_aim(end: Pose, aim: DVec2) -> f64 {
    let left = end.at.distance(aim);
    // Near the aim the direction to it says nothing.
    let heading = if left > 0.15 { end.bearing(aim).abs() } else { 0.0 };
    left + HEADING_WEIGHT / AIM_WEIGHT * heading
}

/// On the spot, slower the nearer.
fn turn(robot: &Robot, bearing: f64) -> Speed {
    let limits = &robot.limits;
    let fastest = (2.0 * limits.turn_acceleration_rad_s2 * bearing.abs() * 0.5).sqrt().min(limits.turn_rad_s);
    Speed { v: 0.0, omega: fastest.copysign(bearing) }
}

/// Speeds that can be reached in a time; forward ones from which the robot can stop at the end of the path.
fn window(robot: &Robot, path: &[DVec2], time_s: f64) -> Vec<Speed> {
    let limits = &robot.limits;
    let left_m = path.last().map_or(0.0, |end| end.distance(robot.believed.at));
    let most = limits.speed_m_s.min((2.0 * limits.acceleration_m_s2 * left_m).sqrt());
    let (v, omega) = (robot.speed.v, robot.speed.omega);
    let (dv, domega) = (limits.acceleration_m_s2 * time_s, limits.turn_acceleration_rad_s2 * time_s);
    let low = (v - dv).clamp(0.0, limits.speed_m_s);
    let high = (v + dv).min(most).max(low);
    let turns = [(omega - domega).max(-limits.turn_rad_s), (omega + domega).min(limits.turn_rad_s)];
    let share = |index: u32, count: u32| f64::from(index) / f64::from(count - 1);
    (0..FORWARD_SAMPLES)
        .flat_map(|i| {
            let v = low + (high - low) * share(i, FORWARD_SAMPLES);
            (0..TURN_SAMPLES)
                .map(move |k| Speed { v, omega: turns[0] + (turns[1] - turns[0]) * share(k, TURN_SAMPLES) })
        })
        .collect()
}

/// Whether a cell that the robot's centre must not be in lies within `reach_m` on the arc that it is on: its own cell counts.
pub fn must_stop(map: &MapUpdate, robot: &Robot, reach_m: f64) -> bool {
    const STEP_M: f64 = 0.02;
    if robot.speed.v.abs() < 1e-6 {
        return false;
    }
    let mut gone_m = 0.0;
    while gone_m <= reach_m {
        let pose = robot.believed.after(robot.speed, gone_m / robot.speed.v.abs());
        if cost_at(map, pose.at).is_some_and(|cost| (253..=254).contains(&cost)) {
            return true;
        }
        gone_m += STEP_M;
    }
    false
}

/// Cost at a place; `None` outside of the map.
pub fn cost_at(map: &MapUpdate, at: DVec2) -> Option<u8> {
    let [x, y] = map.grid.cell_at(at.x, at.y)?;
    map.costmap.get(y as usize * map.grid.width as usize + x as usize).copied()
}
