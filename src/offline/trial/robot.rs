//! The robot: a differential drive with a circular footprint (spec 7 §1).

use glam::{DQuat, DVec2};
use serde::{Deserialize, Serialize};

use crate::base::Rigid;
use crate::sim::generate::Random;

/// Limits of a robot like a TurtleBot.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Radius of the footprint, metres.
    pub radius_m: f64,
    /// Fastest forwards, m/s.
    pub speed_m_s: f64,
    /// Fastest turn, rad/s.
    pub turn_rad_s: f64,
    /// m/s².
    pub acceleration_m_s2: f64,
    /// rad/s².
    pub turn_acceleration_rad_s2: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            radius_m: 0.18,
            speed_m_s: 0.5,
            turn_rad_s: 1.5,
            acceleration_m_s2: 1.0,
            turn_acceleration_rad_s2: 3.0,
        }
    }
}

/// Forward and turning velocity, m/s and rad/s.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Speed {
    /// m/s, forwards.
    pub v: f64,
    /// rad/s, counter-clockwise.
    pub omega: f64,
}

/// Place and heading on the floor.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Metres.
    pub at: DVec2,
    /// Radians, counter-clockwise from x.
    pub yaw: f64,
}

impl Pose {
    /// The base in the map.
    pub fn rigid(self) -> Rigid {
        Rigid { rotation: DQuat::from_rotation_z(self.yaw), translation_m: self.at.extend(0.0) }
    }

    /// After `time_s` at a constant speed: along an arc.
    pub fn after(self, speed: Speed, time_s: f64) -> Self {
        let yaw = self.yaw + speed.omega * time_s;
        let chord = speed.v * time_s * half_sinc(speed.omega * time_s / 2.0);
        Self { at: self.at + DVec2::from_angle(f64::midpoint(self.yaw, yaw)) * chord, yaw }
    }

    /// Angle from the heading to a place, in (-pi, pi].
    pub fn bearing(self, place: DVec2) -> f64 {
        wrapped((place - self.at).to_angle() - self.yaw)
    }
}

/// sin(x) / x.
fn half_sinc(x: f64) -> f64 {
    if x.abs() < 1e-9 { 1.0 } else { x.sin() / x }
}

/// An angle in (-pi, pi].
pub fn wrapped(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    PI - (PI - angle).rem_euclid(TAU)
}

/// Where it is, how it moves, and where its odometry takes it to be.
#[derive(Debug, Clone)]
pub struct Robot {
    /// Its limits.
    pub limits: Limits,
    /// Where it is.
    pub pose: Pose,
    /// Where its odometry takes it to be.
    pub believed: Pose,
    /// How it moves.
    pub speed: Speed,
    /// Deviation of the odometry's error, as a share of the way and of turns; 0: perfect.
    drift: f64,
    random: Random,
}

/// Parts of a step at which collisions are looked for.
pub const PARTS: u32 = 5;

impl Robot {
    /// Standing at a pose.
    pub fn new(limits: Limits, pose: Pose, drift: f64, seed: u64) -> Self {
        let random = Random::new(seed ^ 0x0d0_0000);
        Self { limits, pose, believed: pose, speed: Speed::default(), drift, random }
    }

    /// The speed nearest to `wanted` that can be reached in a time.
    pub fn reachable(&self, wanted: Speed, time_s: f64) -> Speed {
        let step = |from: f64, to: f64, most: f64| from + (to - from).clamp(-most, most);
        let limits = &self.limits;
        Speed {
            v: step(self.speed.v, wanted.v, limits.acceleration_m_s2 * time_s),
            omega: step(self.speed.omega, wanted.omega, limits.turn_acceleration_rad_s2 * time_s),
        }
    }

    /// Moves for a time towards a wanted speed; the poses on its way, the last one included.
    pub fn drive(&mut self, wanted: Speed, time_s: f64) -> Vec<Pose> {
        self.speed = self.reachable(wanted, time_s);
        let part_s = time_s / f64::from(PARTS);
        let poses: Vec<Pose> = (1..=PARTS)
            .map(|_| {
                self.pose = self.pose.after(self.speed, part_s);
                self.pose
            })
            .collect();
        let mut error = || 1.0 + self.drift * (self.random.within(-1.0, 1.0) + self.random.within(-1.0, 1.0));
        let felt = Speed { v: self.speed.v * error(), omega: self.speed.omega * error() };
        // A way straight ahead drifts aside too.
        let aside = self.drift * self.speed.v * (self.random.within(-1.0, 1.0));
        let felt = Speed { omega: felt.omega + aside, ..felt };
        self.believed = if self.drift > 0.0 { self.believed.after(felt, time_s) } else { self.pose };
        poses
    }

    /// Way in which it can stop, metres: it reacts after `reaction_s`.
    pub fn braking_m(&self, reaction_s: f64) -> f64 {
        let v = self.speed.v.abs();
        v * reaction_s + v * v / (2.0 * self.limits.acceleration_m_s2)
    }
}
