//! A trial: world, sensors, map, plan, controller, motion, in a loop of simulated time (spec 7 §1).

use std::time::Instant;

use glam::DVec2;

use super::classes::ClassTally;
use super::controller::{Command, Controller, must_stop};
use super::judge::Judge;
use super::record::{Event, Outcome, Picture, Record, Step, letter_of_cost, runs};
use super::recovery::{Act, Recovery};
use super::robot::{Limits, Robot, Speed};
use super::route::Prices;
use super::sensors::{Placed, Sensors};
use super::setup::Setup;
use super::world::World;
use crate::base::{Error, Result};
use crate::gpu::Context;
use crate::map::{MapUpdate, State};
use crate::mapper::{Mapper, Options, Submitted};
use crate::sim::stamp_ns;

/// The robot stands this long before it is sent, seconds, so that there is a map (spec 1 §6: ten frames).
const STANDS_S: f64 = 1.0;

/// Distance from the goal at which the robot has arrived, metres.
const ARRIVED_M: f64 = 0.3;

/// Progress of less than this in that time is freezing.
const FROZEN_M: f64 = 0.1;
const FROZEN_S: f64 = 15.0;

/// Time between two plans, and between two pictures, seconds.
const PLAN_S: f64 = 1.0;
const PICTURE_S: f64 = 1.0;

/// Slower than this the robot stands, m/s; a stop from a faster way is an emergency stop.
const CREEP_M_S: f64 = 0.02;

/// What may differ between trials of one setting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terms {
    /// Deviation of the odometry's error, as a share of the way and of turns.
    pub drift: f64,
    /// When the sensors die, seconds after the start.
    pub dies_at_s: Option<f64>,
    /// The time that it may take, as a multiple of the shortest way's at full speed.
    pub time_share: f64,
}

impl Default for Terms {
    fn default() -> Self {
        Self { drift: 0.0, dies_at_s: None, time_share: 4.0 }
    }
}

/// Names of a trial in its record.
#[derive(Debug, Clone, PartialEq)]
pub struct Label {
    /// Scenario.
    pub scenario: String,
    /// Glare level.
    pub level: String,
    /// Of world and task.
    pub seed: u64,
}

/// Drives through a world with the map of a set-up, and tells what came of it.
///
/// # Errors
/// Those of simulators and mapper; a task that cannot be done is none, but [`Outcome::Impossible`].
pub fn drive(
    context: &Context,
    world: &World,
    setup: &Setup,
    limits: &Limits,
    terms: Terms,
    label: &Label,
) -> Result<Record> {
    let begun = Instant::now();
    let mut record = blank(world, setup, label);
    if let Some(reason) = &world.impossible {
        record.outcome = Outcome::Impossible { reason: reason.clone() };
        return Ok(record);
    }
    let mut drive = Drive::open(context, world, setup, limits, terms, label.seed, record)?;
    let outcome = drive.run()?;
    let mut record = drive.finish(outcome);
    record.wall_s = begun.elapsed().as_secs_f64();
    Ok(record)
}

/// A record of nothing yet.
fn blank(world: &World, setup: &Setup, label: &Label) -> Record {
    Record {
        scenario: label.scenario.clone(),
        level: label.level.clone(),
        method: setup.key.into(),
        seed: label.seed,
        settings: String::new(),
        scene: world.scene.name.clone(),
        outcome: Outcome::Timeout,
        time_s: 0.0,
        driven_m: 0.0,
        left_m: world.start.at.distance(world.goal),
        ideal_m: world.ideal_m(),
        stops: 0,
        recoveries: 0,
        map: Default::default(),
        classes: ClassTally::default(),
        depth: None,
        wall_s: 0.0,
        task: [world.start.at, world.goal].map(|at| at.to_array()),
        ideal: world.ideal.iter().map(|at| at.to_array()).collect(),
        steps: Vec::new(),
        events: Vec::new(),
        outlines: world.outlines(),
        truth: None,
        pictures: Vec::new(),
    }
}

/// A trial under way.
struct Drive<'a> {
    context: &'a Context,
    world: &'a World,
    setup: &'a Setup,
    terms: Terms,
    sensors: Sensors,
    mapper: Mapper,
    map: Option<MapUpdate>,
    robot: Robot,
    before: Placed,
    controller: Option<Controller>,
    recovery: Recovery,
    judge: Judge,
    path: Vec<DVec2>,
    planned_s: f64,
    is_stopping: bool,
    /// Where the robot was when it last made progress.
    anchor: (DVec2, f64),
    /// Way and time at the sensor's last data.
    last_data: (f64, f64),
    tick: u64,
    step_s: f64,
    record: Record,
}

fn open_mapper(context: &Context, setup: &Setup, sensors: &Sensors) -> Result<Mapper> {
    let options = Options { live: true, ..Options::default() };
    Mapper::on(context, &setup.config, sensors.infos(), &options)
}

impl<'a> Drive<'a> {
    fn open(
        context: &'a Context,
        world: &'a World,
        setup: &'a Setup,
        limits: &Limits,
        terms: Terms,
        seed: u64,
        record: Record,
    ) -> Result<Self> {
        let sensors = Sensors::open(context, &world.scene, setup, world.start)?;
        let mapper = open_mapper(context, setup, &sensors)?;
        let robot = Robot::new(*limits, world.start, terms.drift, seed);
        let standing = Placed { truly: robot.pose, believed: robot.believed };
        Ok(Self {
            context,
            world,
            setup,
            terms,
            sensors,
            mapper,
            map: None,
            robot,
            before: standing,
            controller: None,
            recovery: Recovery::default(),
            judge: Judge::new(world, setup),
            path: Vec::new(),
            planned_s: f64::NEG_INFINITY,
            is_stopping: false,
            anchor: (world.start.at, STANDS_S),
            last_data: (0.0, 0.0),
            tick: 0,
            step_s: 1.0 / world.scene.trajectory.rate_hz,
            record,
        })
    }

    fn now_s(&self) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "some thousand ticks")]
        let ticks = self.tick as f64;
        ticks * self.step_s
    }

    /// Steps until the trial ends.
    fn run(&mut self) -> Result<Outcome> {
        loop {
            self.look()?;
            if let Some(outcome) = self.ended() {
                return Ok(outcome);
            }
            let wanted = self.decide()?;
            if let Some(outcome) = self.step(wanted) {
                return Ok(outcome);
            }
        }
    }

    /// What the sensors see goes into the map, and the map is published.
    fn look(&mut self) -> Result<()> {
        let (tick, now_s) = (self.tick, self.now_s());
        let here = Placed { truly: self.robot.pose, believed: self.robot.believed };
        if self.terms.dies_at_s.is_none_or(|dies_at_s| now_s < dies_at_s) {
            let looked = self.sensors.look(tick, [self.before, here])?;
            for mut observation in looked.observations {
                observation.goal_m = Some(self.world.goal);
                if let Submitted::Refused(reason) = self.mapper.submit(&observation)? {
                    let reason = reason.to_string();
                    return Err(Error::Input { what: "simulated observation".into(), reason });
                }
            }
            if let Some(frame) = &looked.frame {
                self.judge.see(frame, tick);
            }
            self.last_data = (self.record.driven_m, now_s);
        }
        self.mapper.publish(Some(stamp_ns(&self.world.scene, tick)))?;
        while let Some(update) = self.mapper.wait()? {
            self.map = update.map.or(self.map.take());
        }
        if let Some(map) = &self.map {
            self.judge.score(map, tick)?;
            self.picture();
        }
        Ok(())
    }

    /// Keeps the map once a second.
    fn picture(&mut self) {
        let now_s = self.now_s();
        let due = self.record.pictures.last().is_none_or(|last| now_s - last.t_s > PICTURE_S - 1e-6);
        if let (Some(map), true) = (&self.map, due) {
            self.record.pictures.push(Picture {
                t_s: now_s,
                origin_m: [map.grid.origin_x_m, map.grid.origin_y_m],
                cell_m: map.grid.resolution_m,
                width: map.grid.width,
                runs: runs(map.costmap.iter().map(|&cost| letter_of_cost(cost))),
                path: self.path.iter().map(|at| at.to_array()).collect(),
            });
        }
    }

    /// Whether the trial is over, collisions apart.
    fn ended(&mut self) -> Option<Outcome> {
        let (now_s, at) = (self.now_s(), self.robot.pose.at);
        if now_s < STANDS_S {
            return None;
        }
        if at.distance(self.world.goal) <= ARRIVED_M {
            return Some(Outcome::Arrived);
        }
        let is_stale = self.map.as_ref().is_some_and(|map| map.state >= State::Stale);
        if is_stale && self.robot.speed == Speed::default() {
            let (way_m, after_s) = (self.record.driven_m - self.last_data.0, now_s - self.last_data.1);
            return Some(Outcome::Halted { way_m, after_s });
        }
        if at.distance(self.anchor.0) >= FROZEN_M {
            self.anchor = (at, now_s);
        }
        if now_s - self.anchor.1 >= FROZEN_S {
            return Some(Outcome::Frozen);
        }
        let allowed_s = self.terms.time_share * self.world.ideal_m() / self.robot.limits.speed_m_s;
        (now_s - STANDS_S > allowed_s).then_some(Outcome::Timeout)
    }

    /// The wanted speed.
    fn decide(&mut self) -> Result<Speed> {
        let now_s = self.now_s();
        let Some(map) = self.map.take() else { return Ok(Speed::default()) };
        let wanted = if now_s < STANDS_S { Speed::default() } else { self.steer(&map, now_s)? };
        self.map = Some(map);
        Ok(wanted)
    }

    fn steer(&mut self, map: &MapUpdate, now_s: f64) -> Result<Speed> {
        if map.state >= State::Stale {
            self.tell_once("stale");
            return Ok(Speed::default());
        }
        let must_stop = must_stop(map, &self.robot, self.robot.braking_m(self.step_s));
        if must_stop && self.robot.speed.v.abs() > CREEP_M_S {
            if !self.is_stopping && self.robot.speed.v > 0.0 {
                self.record.stops += 1;
                self.tell("stop");
            }
            self.is_stopping = true;
            self.planned_s = f64::NEG_INFINITY;
            return Ok(Speed::default());
        }
        self.is_stopping = false;
        if let Some(speed) = self.recovery.speed(&self.robot, map, self.step_s) {
            self.planned_s = f64::NEG_INFINITY;
            return Ok(speed);
        }
        self.follow(map, now_s)
    }

    /// Along the path, planned anew where it is old or was blocked.
    fn follow(&mut self, map: &MapUpdate, now_s: f64) -> Result<Speed> {
        if now_s - self.planned_s > PLAN_S - 1e-6 {
            let at = self.robot.believed.at;
            self.path = Prices::around(map, at, self.world.goal).way(at, self.world.goal).unwrap_or_default();
            self.planned_s = now_s;
        }
        let controller = match &mut self.controller {
            Some(controller) => controller,
            None => self.controller.insert(Controller::new(
                self.context,
                map.grid.width,
                map.grid.resolution_m,
                &self.robot,
            )?),
        };
        if let Command::Go(speed) = controller.command(map, &self.robot, &self.path, self.step_s)? {
            self.recovery.free();
            return Ok(speed);
        }
        self.planned_s = f64::NEG_INFINITY;
        if let Some(act) = self.recovery.blocked(self.step_s) {
            self.tell(act.name());
            if act == Act::Clear {
                self.mapper = open_mapper(self.context, self.setup, &self.sensors)?;
            }
        }
        Ok(Speed::default())
    }

    /// Moves; the end of the trial where it touches something.
    fn step(&mut self, wanted: Speed) -> Option<Outcome> {
        self.before = Placed { truly: self.robot.pose, believed: self.robot.believed };
        let mut at = self.robot.pose.at;
        let poses = self.robot.drive(wanted, self.step_s);
        self.tick += 1;
        let (pose, speed) = (self.robot.pose, self.robot.speed);
        let step =
            Step { t_s: self.now_s(), pose: [pose.at.x, pose.at.y, pose.yaw], speed: [speed.v, speed.omega] };
        self.record.steps.push(step);
        for pose in poses {
            self.record.driven_m += at.distance(pose.at);
            at = pose.at;
            if let Some(with) = self.world.touched(at, self.robot.limits.radius_m) {
                let with = with.to_owned();
                self.tell("collision");
                return Some(Outcome::Collision { with });
            }
        }
        None
    }

    fn tell(&mut self, what: &str) {
        self.record.events.push(Event { t_s: self.now_s(), what: what.into() });
    }

    fn tell_once(&mut self, what: &str) {
        if self.record.events.last().is_none_or(|last| last.what != what) {
            self.tell(what);
        }
    }

    fn finish(mut self, outcome: Outcome) -> Record {
        self.record.time_s = self.now_s() - STANDS_S;
        self.record.left_m = self.robot.pose.at.distance(self.world.goal);
        self.record.recoveries = self.recovery.begun();
        self.record.outcome = outcome;
        self.judge.finish(&mut self.record);
        self.record
    }
}
