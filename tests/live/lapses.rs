//! What goes wrong with sensors, transforms, time and peers: how long until it is seen, how long until all is well again.
//!
//! In all of it free space of what is not seen any more goes, and no old map is told as a new one.

use std::time::{Duration, Instant};

use limpid::Config;
use limpid::ros2::Environment;

use super::node::listener;
use super::peer::{Costs, Diagnostics, Node, Peer, domain, no_network, node_options};
use super::robot::{Robot, Script, eye};
use crate::support::gpu::skipped;
use crate::support::say;

const RAW: u32 = 2;
const DIAGNOSTICS: u32 = 3;

/// Longest time from a lapse to its sight: the sensor's timeout, a publishing period, and what a busy machine needs.
const SEEN: Duration = Duration::from_secs(8);

/// A node, a robot and who watches both.
struct Scene {
    environment: Environment,
    peer: Peer,
    node: Node,
    robot: Robot,
    /// Newest stamp of a map, nanoseconds.
    newest_ns: u64,
}

impl Scene {
    /// Starts all and waits for free space. `None` where it cannot be tested.
    fn set(config: Config) -> Option<Self> {
        if no_network() || skipped() {
            return None;
        }
        let environment = domain();
        let peer = listener(&environment);
        let simulates_time = config.use_sim_time;
        let node = Node::start(&environment, node_options(config));
        let robot = Robot::start(&environment, Script::default(), simulates_time);
        let mut scene = Self { environment, peer, node, robot, newest_ns: 0 };
        scene.until_free();
        Some(scene)
    }

    fn next(&mut self, fits: impl Fn(&Costs) -> bool) -> Costs {
        let costs = self.peer.wait_for::<Costs>(RAW, fits);
        self.newest_ns = costs.header.stamp.stamp_ns().unwrap();
        costs
    }

    /// Waits until no cell is free; how long it took.
    fn until_blind(&mut self) -> Duration {
        let began = Instant::now();
        let before_ns = self.newest_ns;
        let blind = self.next(|costs| !costs.data.contains(&0));
        assert!(blind.header.stamp.stamp_ns().unwrap() >= before_ns, "the stamps are those of the sensors");
        began.elapsed()
    }

    /// Waits until cells are free; how long it took.
    fn until_free(&mut self) -> Duration {
        let began = Instant::now();
        self.next(|costs| costs.data.contains(&0));
        began.elapsed()
    }

    /// Passes over what was sent so far.
    fn forget(&self) {
        while self.peer.next(Instant::now()).is_some() {}
    }

    fn tell(&self, what: &str, seen: Duration, well: Duration) {
        say(&format!(
            "{what}: seen after {:.2} s, well after {:.2} s",
            seen.as_secs_f64(),
            well.as_secs_f64()
        ));
        assert!(seen < SEEN, "{what}: seen after {seen:?}");
    }

    /// No cell stays free while a lapse lasts, and the cells come back after it.
    fn lapse(&mut self, what: &str, begin: impl FnOnce(&mut Script), end: impl FnOnce(&mut Script)) {
        self.robot.does(begin);
        let seen = self.until_blind();
        let said = self.peer.wait_for::<Diagnostics>(DIAGNOSTICS, |said| said.status[0].level == 2);
        assert!(said.status[0].message.contains("STALE"), "{said:?}");
        self.robot.does(end);
        let well = self.until_free();
        self.tell(what, seen, well);
    }
}

#[test]
fn frames_and_transforms_that_stop_leave_no_free_space() {
    let Some(mut scene) = Scene::set(eye()) else { return };
    scene.lapse("frames stop", |robot| robot.frames = false, |robot| robot.frames = true);
    scene.lapse("tf stops", |robot| robot.transforms = false, |robot| robot.transforms = true);
    scene.node.end();
}

#[test]
fn a_publisher_that_dies_is_replaced_by_another() {
    let Some(mut scene) = Scene::set(eye()) else { return };
    let gone = std::mem::replace(&mut scene.robot, Robot::start(&scene.environment, silent(), false));
    drop(gone);
    let seen = scene.until_blind();
    scene.robot.does(|robot| *robot = Script::default());
    let well = scene.until_free();
    scene.tell("publisher killed, another started", seen, well);
    scene.node.end();
}

fn silent() -> Script {
    Script { frames: false, transforms: false, ..Script::default() }
}

#[test]
fn a_jump_of_the_robot_moves_the_map_and_a_circle_of_frames_ends_nothing() {
    let Some(mut scene) = Scene::set(eye()) else { return };
    let before_m = scene.next(|costs| costs.data.contains(&0)).origin.position.x;
    scene.robot.does(|robot| robot.x_m = 50.0);
    let began = Instant::now();
    let moved = scene.next(|costs| costs.origin.position.x > before_m + 40.0);
    // Nothing of the old place is in the new window: the robot has not seen what lies behind it.
    let side = moved.size_x as usize;
    let behind = moved.data.chunks_exact(side).flat_map(|row| &row[..side / 2 - 2]);
    assert!(behind.copied().all(|cost| cost != 0), "free behind the robot");
    say(&format!("tf jumps: the map follows after {:.2} s", began.elapsed().as_secs_f64()));

    let began = Instant::now();
    scene.robot.does(|robot| robot.circle = true);
    std::thread::sleep(Duration::from_millis(500));
    scene.robot.does(|robot| robot.circle = false);
    scene.forget();
    scene.until_free();
    say(&format!("tf has a circle for 0.5 s: well after {:.2} s", began.elapsed().as_secs_f64()));
    scene.node.end();
}

#[test]
fn clocks_that_are_set_start_the_map_over() {
    let Some(mut scene) = Scene::set(eye()) else { return };
    for (what, off_s) in [("an hour forward", 3600), ("an hour back", -3600)] {
        let before_ns = scene.newest_ns;
        scene.forget();
        let began = Instant::now();
        scene.robot.does(|robot| robot.stamps_off_s += off_s);
        let apart = |costs: &Costs| {
            let stamp_ns = costs.header.stamp.stamp_ns().unwrap();
            stamp_ns.abs_diff(before_ns) > 3_000_000_000_000
        };
        scene.next(|costs| apart(costs) && costs.data.contains(&0));
        say(&format!("stamps go {what}: well after {:.2} s", began.elapsed().as_secs_f64()));
    }
    scene.node.wait_for("the map begins anew: stamps jumped back", 1);
    scene.node.end();
}

#[test]
fn a_camera_that_changes_is_learned_anew() {
    let Some(mut scene) = Scene::set(eye()) else { return };
    // The wall is as wide as the camera's field of view: 2.6 m, and 5.2 m with half the focal length.
    let width_m = |costs: &Costs| {
        let rows = costs.data.chunks_exact(costs.size_x as usize).filter(|row| row.contains(&254));
        rows.count() as f64 * f64::from(costs.resolution)
    };
    assert!(width_m(&scene.next(|costs| costs.data.contains(&254))) < 4.0);
    let began = Instant::now();
    scene.robot.does(|robot| robot.focal_px = 25.0);
    scene.next(|costs| width_m(costs) > 4.0);
    say(&format!("calibration changes: used after {:.2} s", began.elapsed().as_secs_f64()));

    let began = Instant::now();
    scene.robot.does(|robot| robot.size = (80, 60));
    scene.node.wait_for("a sensor has changed", 1);
    let seen = began.elapsed();
    scene.forget();
    let well = seen + scene.until_free();
    scene.tell("image size changes", seen, well);
    scene.node.end();
}

#[test]
fn time_that_stands_still_makes_no_new_map() {
    let Some(mut scene) = Scene::set(Config { use_sim_time: true, ..eye() }) else { return };
    scene.robot.does(|robot| (robot.clock, robot.frames, robot.transforms) = (false, false, false));
    // What was under way comes, then no map for a while.
    let (began, quiet) = (Instant::now(), Duration::from_millis(1500));
    let mut last = began;
    while last.elapsed() < quiet {
        assert!(began.elapsed() < SEEN, "maps while time stands still");
        if scene.peer.next(Instant::now() + Duration::from_millis(100)).is_some_and(|(topic, _)| topic == RAW)
        {
            last = Instant::now();
        }
    }
    let paused = began.elapsed();
    scene.robot.does(|robot| (robot.clock, robot.frames, robot.transforms) = (true, true, true));
    let well = scene.until_free();
    scene.tell(&format!("/clock stands still for {:.1} s", paused.as_secs_f64()), Duration::ZERO, well);
    // Without frames time goes on, and what is free goes.
    scene.lapse("frames stop in simulated time", |robot| robot.frames = false, |robot| robot.frames = true);
    scene.node.end();
}

#[test]
fn another_node_of_the_same_name_is_told() {
    let Some(mut scene) = Scene::set(eye()) else { return };
    let began = Instant::now();
    let other = Node::start(&scene.environment, node_options(eye()));
    scene.node.wait_for("somebody else publishes /limpid/costmap too", 1);
    let seen = began.elapsed();
    other.wait_for("somebody else publishes /limpid/costmap too", 1);
    other.end();
    scene.forget();
    let well = scene.until_free();
    scene.tell("two nodes of one name", seen, well);
    scene.node.end();
}

#[test]
fn who_asks_for_what_is_not_offered_is_told() {
    let Some(scene) = Scene::set(eye()) else { return };
    let latched = limpid::ros2::Quality::Latched { depth: 1 };
    let kind = "map_msgs/msg/OccupancyGridUpdate";
    let asked = scene.peer.participant.subscribe("/limpid/costmap_updates", kind, latched).unwrap();
    scene
        .node
        .wait_for("/limpid/costmap_updates is published as reliable and volatile, but somebody asks", 1);
    drop(asked);
    scene.node.end();
}
