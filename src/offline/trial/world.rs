//! A world to drive through: its scene, what stands in it, start, goal and the shortest way (spec 7 §1).

use glam::DVec2;

use super::robot::{Limits, Pose};
use super::route::{BLOCKED, FREE_PRICE, Prices, length_m};
use crate::base::Result;
use crate::config::Config;
use crate::map::Grid;
use crate::sim::Scene;
use crate::sim::footprint::{Footprint, Shape, footprints};
use crate::sim::generate::{Family, Level, Random, generate};
use crate::sim::scene::Trajectory;
use crate::sim::truth::TrueMap;
use crate::sim::walls::is_inside;

/// How far start and goal are apart, metres, where the scene allows it (spec 7 §2).
pub const APART_M: [f64; 2] = [8.0, 15.0];

/// Floor that start and goal keep free around the robot, metres beyond its radius.
const ROOM_M: f64 = 0.3;

/// Width that the shortest way needs beside the robot, metres: what a costmap's cells cost at an obstacle's border.
const CELLS_M: f64 = 0.08;

/// Pairs that are drawn in a scene, and scenes that are drawn, before giving up.
const PAIRS: u32 = 60;
const SCENES: u64 = 8;

/// Seeds of a trial's other scenes lie this far apart: a multiple of 3, so that a corridor stays a corridor.
const SEED_STEP: u64 = 999_999;

/// Half the angle that the robot's heading at the start is off the way, radians.
const TURNED_RAD: f64 = 0.5;

/// A world with a task in it.
pub struct World {
    /// The scene.
    pub scene: Scene,
    /// Where the robot begins.
    pub start: Pose,
    /// Where it is to go, metres.
    pub goal: DVec2,
    /// Why the task cannot be done; `None` where it can.
    pub impossible: Option<String>,
    /// The shortest way on the true map; empty where there is none.
    pub ideal: Vec<DVec2>,
    obstacles: Vec<Footprint>,
}

impl World {
    /// A task in a scene, whatever it is; height band and cells are the configuration's.
    ///
    /// # Errors
    /// [`crate::Error::Config`] with the key of the scene where that cannot be; a task that cannot be done is no error
    /// ([`World::impossible`]).
    pub fn new(scene: &Scene, start: Pose, goal: DVec2, limits: &Limits, config: &Config) -> Result<Self> {
        let obstacles = obstacles(scene, config);
        let floor = || free_floor(scene, &obstacles, limits, config);
        Self::on(floor, scene, obstacles.clone(), (start, goal), limits)
    }

    /// As [`World::new`], where the floor's prices may be known already.
    fn on<Floor: std::borrow::Borrow<Prices>>(
        floor: impl FnOnce() -> Floor,
        scene: &Scene,
        obstacles: Vec<Footprint>,
        (start, goal): (Pose, DVec2),
        limits: &Limits,
    ) -> Result<Self> {
        let mut scene = scene.clone();
        scene.trajectory = standing(&scene.trajectory);
        let mut world = Self { scene, start, goal, impossible: None, ideal: Vec::new(), obstacles };
        world.impossible = world.fault(limits);
        if world.impossible.is_none() {
            world.scene.trajectory.waypoints_m = vec![start.at.to_array()];
            world.scene.validate()?;
            match floor().borrow().way(start.at, goal) {
                Some(way) => world.ideal = way,
                None => world.impossible = Some("the goal cannot be reached on the true map".into()),
            }
        }
        Ok(world)
    }

    /// What is wrong with start, goal or floor, before any way is looked for.
    fn fault(&self, limits: &Limits) -> Option<String> {
        if self.scene.rooms.is_empty() {
            return Some("the world has no floor".into());
        }
        if !self.scene.walkers.is_empty() {
            return Some("people walk in the world, and collisions with them are not looked for".into());
        }
        for (what, at) in [("start", self.start.at), ("goal", self.goal)] {
            if !at.is_finite() {
                return Some(format!("the {what} is not a place"));
            }
            if !is_inside(&self.scene, at.x, at.y) {
                return Some(format!("the {what} lies outside of the world"));
            }
            if let Some(thing) = self.touched(at, limits.radius_m) {
                return Some(format!("the {what} lies in or at an obstacle, {thing}"));
            }
        }
        None
    }

    /// The world of a seed: start and goal 8 to 15 m apart where one of a few scenes allows that, else as far as it can be. Where no
    /// task asks for what the family is about, the world says so ([`World::impossible`]): driving another one would tell nothing.
    ///
    /// # Errors
    /// [`crate::Error::Config`] where the family has no such scene.
    pub fn generated(
        family: Family,
        level: Level,
        seed: u64,
        limits: &Limits,
        config: &Config,
    ) -> Result<Self> {
        let mut best: Option<((bool, f64), Self)> = None;
        for attempt in 0..SCENES {
            let scene = generate(family, level, seed + attempt * SEED_STEP, 1)?;
            let mut random = Random::new(seed ^ (attempt << 40) ^ 0x7217);
            let floors = Floors::of(&scene, family, limits, config);
            for _ in 0..PAIRS {
                let Some(world) = Self::drawn(&scene, &floors, &mut random, limits)? else { continue };
                let apart_m = world.start.at.distance(world.goal);
                let rank = (world.asks_for(family, &floors), apart_m);
                if rank.0 && apart_m >= APART_M[0] {
                    return Ok(world);
                }
                if best.as_ref().is_none_or(|(other, _)| rank > *other) {
                    best = Some((rank, world));
                }
            }
            if best.as_ref().is_some_and(|(rank, _)| rank.0) && !reaches(&scene) {
                break;
            }
        }
        match best {
            Some(((true, _), world)) => Ok(world),
            Some((_, world)) => Ok(Self { impossible: Some(unasked(family).into()), ..world }),
            None => Ok(Self {
                scene: generate(family, level, seed, 1)?,
                start: Pose { at: DVec2::ZERO, yaw: 0.0 },
                goal: DVec2::ZERO,
                impossible: Some("there is no way through the scenes of this seed".into()),
                ideal: Vec::new(),
                obstacles: Vec::new(),
            }),
        }
    }

    /// Whether the task asks for what the family is about. With cameras alone no pane may cut the way: none of them sees panes, and
    /// what is measured is glare. Among glass one must; where there is a curtain, the way goes through it.
    fn asks_for(&self, family: Family, floors: &Floors) -> bool {
        let Some(other) = &floors.other else { return true };
        let other_m = other.way(self.start.at, self.goal).map(|way| length_m(&way));
        let cut_by_glass = || other_m.is_some_and(|other_m| other_m < 0.99 * self.ideal_m());
        match family {
            Family::Drive => !cut_by_glass(),
            Family::Glass => cut_by_glass(),
            _ => other_m.is_none_or(|other_m| other_m > 1.05 * self.ideal_m()),
        }
    }

    /// A task between two places drawn at random; `None` where they do not do.
    fn drawn(scene: &Scene, floors: &Floors, random: &mut Random, limits: &Limits) -> Result<Option<Self>> {
        let clear_m = limits.radius_m + ROOM_M;
        let things = &floors.obstacles;
        let mut place = || {
            let room =
                &scene.rooms[random.count(0, u32::try_from(scene.rooms.len() - 1).unwrap_or(0)) as usize];
            DVec2::new(
                random.within(room.min_m[0], room.max_m[0]),
                random.within(room.min_m[1], room.max_m[1]),
            )
        };
        let (start, goal) = (place(), place());
        let turned = random.within(-TURNED_RAD, TURNED_RAD);
        let free = |at: DVec2| things.iter().all(|thing| thing.shape.distance_m(at) > clear_m);
        let apart_m = start.distance(goal);
        let wanted_m = if reaches(scene) { APART_M[0] } else { 3.0 };
        if !(wanted_m..=APART_M[1]).contains(&apart_m) || !free(start) || !free(goal) {
            return Ok(None);
        }
        let task = (Pose { at: start, yaw: 0.0 }, goal);
        let world = Self::on(|| &floors.all, scene, things.clone(), task, limits)?;
        let too_long = length_m(&world.ideal) > 1.6 * APART_M[1];
        if world.impossible.is_some() || too_long {
            return Ok(None);
        }
        let first = super::route::ahead(&world.ideal, start, 1.0).unwrap_or(goal);
        Ok(Some(Self { start: Pose { at: start, yaw: (first - start).to_angle() + turned }, ..world }))
    }

    /// Key of an obstacle that a disc touches.
    pub fn touched(&self, at: DVec2, radius_m: f64) -> Option<&str> {
        touched(&self.obstacles, at, radius_m).map(|thing| thing.key.as_str())
    }

    /// The shortest way, metres.
    pub fn ideal_m(&self) -> f64 {
        length_m(&self.ideal)
    }

    /// Outlines of obstacles and of passable things on the floor, for pictures.
    pub fn outlines(&self) -> Vec<Outline> {
        footprints(&self.scene).iter().map(Outline::of).collect()
    }
}

/// The floor of a scene, with all obstacles and with those by which a family's tasks are told.
struct Floors {
    obstacles: Vec<Footprint>,
    all: Prices,
    /// Without glass, or with what can be passed in the way too.
    other: Option<Prices>,
}

impl Floors {
    fn of(scene: &Scene, family: Family, limits: &Limits, config: &Config) -> Self {
        let obstacles = obstacles(scene, config);
        let others: Option<Vec<_>> = match family {
            Family::Drive | Family::Glass => {
                Some(obstacles.iter().filter(|thing| !thing.glass).cloned().collect())
            }
            Family::Curtain | Family::Mixed => {
                Some(footprints(scene).into_iter().filter(|thing| is_in_band(thing, config)).collect())
            }
            _ => None,
        };
        let floor = |obstacles: &[Footprint]| free_floor(scene, obstacles, limits, config);
        Self { all: floor(&obstacles), other: others.map(|others| floor(&others)), obstacles }
    }
}

/// Prices of the true map: cells that the robot's centre may be in, with the width of a cell to spare.
fn free_floor(scene: &Scene, obstacles: &[Footprint], limits: &Limits, config: &Config) -> Prices {
    let grid = TrueMap::new(scene, config).grid();
    let is_free = |at: &DVec2| {
        is_inside(scene, at.x, at.y) && touched(obstacles, *at, limits.radius_m + CELLS_M).is_none()
    };
    let cells = cells_of(&grid).map(|at| if is_free(&at) { FREE_PRICE } else { BLOCKED }).collect();
    Prices { grid, cells }
}

/// An obstacle that a disc touches.
fn touched(obstacles: &[Footprint], at: DVec2, radius_m: f64) -> Option<&Footprint> {
    obstacles.iter().find(|thing| thing.shape.distance_m(at) < radius_m)
}

/// What no task of a seed asks for.
fn unasked(family: Family) -> &'static str {
    match family {
        Family::Drive => "glass cuts every way through the scenes of this seed, and a camera sees none",
        Family::Glass => "no pane cuts a way through the scenes of this seed",
        Family::Curtain | Family::Mixed => "no way through the scenes of this seed needs its curtain",
        _ => "no task in the scenes of this seed",
    }
}

/// An outline on the floor, for pictures.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Outline {
    /// `solid`, `glass` or `passable`.
    pub kind: String,
    /// Corners, metres; two are a line.
    pub corners: Vec<[f64; 2]>,
}

impl Outline {
    fn of(thing: &Footprint) -> Self {
        let kind = match (thing.glass, thing.passable) {
            (true, _) => "glass",
            (_, true) => "passable",
            _ => "solid",
        };
        let around = |center: DVec2, half: DVec2, turn: DVec2, parts: u32| -> Vec<DVec2> {
            let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(parts);
            (0..parts).map(|k| center + turn.rotate(DVec2::from_angle(angle(k)) * half)).collect()
        };
        let corners = match thing.shape {
            Shape::Segment(a, b) => vec![a, b],
            Shape::Disc(center, radius) => around(center, DVec2::splat(radius), DVec2::X, 16),
            Shape::Oval(center, half, turn) => around(center, half, turn, 24),
            Shape::Rectangle(center, half, turn) => [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| center + turn.rotate(half * DVec2::new(x, y)))
                .into(),
        };
        Self { kind: kind.into(), corners: corners.into_iter().map(|at| at.to_array()).collect() }
    }
}

/// What the robot must not touch: everything in the map's height band that it cannot pass.
fn obstacles(scene: &Scene, config: &Config) -> Vec<Footprint> {
    let stops = |thing: &Footprint| is_in_band(thing, config) && !thing.passable;
    footprints(scene).into_iter().filter(stops).collect()
}

fn is_in_band(thing: &Footprint, config: &Config) -> bool {
    thing.span_m[1] >= config.height_min_m && thing.span_m[0] <= config.height_max_m
}

/// Centres of all cells, row by row.
fn cells_of(grid: &Grid) -> impl Iterator<Item = DVec2> + '_ {
    (0..grid.height).flat_map(move |y| (0..grid.width).map(move |x| DVec2::from_array(grid.centre_m(x, y))))
}

/// Whether places of a scene can be as far apart as wanted.
fn reaches(scene: &Scene) -> bool {
    let bound = |axis: usize| {
        let low = scene.rooms.iter().map(|room| room.min_m[axis]).fold(f64::INFINITY, f64::min);
        let high = scene.rooms.iter().map(|room| room.max_m[axis]).fold(f64::NEG_INFINITY, f64::max);
        high - low
    };
    DVec2::new(bound(0), bound(1)).length() > APART_M[0] + 2.0
}

/// A robot that stands at its start: a trial's own motion takes the place of the scene's way.
fn standing(way: &Trajectory) -> Trajectory {
    Trajectory { frames: 1, clearance_m: 0.05, ..way.clone() }
}
