//! Nodes, players and subscribers as processes of their own: paused, ended, cut off from the network.

use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use limpid::ros2::{Environment, Quality};

use super::node::listener;
use super::peer::{Costs, Diagnostics, Node, PATIENCE, Peer, domain, no_network, node_options};
use super::robot::{DEPTH, Robot, Script, eye};
use crate::cli::ROOM;
use crate::support::gpu::skipped;
use crate::support::say;

const RAW: u32 = 2;
const DIAGNOSTICS: u32 = 3;

/// A process that is killed when it is dropped.
struct Process(Child);

impl Process {
    fn start(mut command: Command, environment: &Environment) -> Self {
        command.env("ROS_DOMAIN_ID", environment.domain.to_string());
        command.env("ROS_LOCALHOST_ONLY", if environment.localhost_only { "1" } else { "0" });
        Self(command.stdout(Stdio::null()).spawn().unwrap())
    }

    fn limpid(environment: &Environment, arguments: &[&str]) -> Self {
        let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
        command.args(arguments);
        Self::start(command, environment)
    }

    fn signal(&self, signal: &str) {
        let sent = Command::new("kill").args([signal, &self.0.id().to_string()]).status().unwrap();
        assert!(sent.success());
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Whether a test that takes a minute is left out: it is run where `LIMPID_LIVE_LONG` is 1 (`make live-faults`).
fn too_long(what: &str) -> bool {
    let asked = std::env::var("LIMPID_LIVE_LONG").is_ok_and(|value| value == "1");
    if !asked {
        say(&format!("skipped, as LIMPID_LIVE_LONG is not 1: {what}"));
    }
    !asked
}

fn free(costs: &Costs) -> bool {
    costs.data.contains(&0)
}

#[test]
fn a_player_that_is_paused_leaves_no_free_space() {
    if no_network() || skipped() || too_long("a player that is paused") {
        return;
    }
    let environment = domain();
    let peer = listener(&environment);
    let config =
        limpid::Config { timeout_s: 0.7, map_size_m: 6.0, resolution_m: 0.1, ..super::node::config() };
    let node = Node::start(&environment, node_options(config));
    let player = Process::limpid(
        &environment,
        &["play", ROOM, "--loop", "--rate", "0.5", "--reliable", "--wait", "30"],
    );
    peer.wait_for::<Costs>(RAW, free);
    player.signal("-STOP");
    let began = Instant::now();
    peer.wait_for::<Costs>(RAW, |costs| !free(costs));
    let seen = began.elapsed();
    player.signal("-CONT");
    let began = Instant::now();
    peer.wait_for::<Costs>(RAW, free);
    let (seen_s, well_s) = (seen.as_secs_f64(), began.elapsed().as_secs_f64());
    say(&format!("publisher paused (SIGSTOP): seen after {seen_s:.2} s, well after {well_s:.2} s"));
    assert!(seen < Duration::from_secs(8), "{seen:?}");
    node.end();
}

#[test]
fn sigterm_ends_a_node_in_the_middle_of_its_work_with_its_map_unknown() {
    if no_network() || skipped() {
        return;
    }
    let environment = domain();
    let peer = listener(&environment);
    let depth = format!("depth_topic:={DEPTH}");
    let arguments = ["node", "--method", "range", "--ros-args", "-p", &depth, "-p", "ground:=stated"];
    let mut node = Process::limpid(&environment, &arguments);
    let _robot = Robot::start(&environment, Script::default(), false);
    peer.wait_for::<Costs>(RAW, free);
    node.signal("-TERM");
    let asked = Instant::now();
    let status = node.0.wait().unwrap();
    let took = asked.elapsed();
    assert!(status.success() && took < Duration::from_millis(1500), "{status} after {took:?}");
    peer.wait_for::<Costs>(RAW, |costs| costs.data.iter().all(|&cost| cost == 255));
    say(&format!("SIGTERM: ended after {:.2} s, map unknown", took.as_secs_f64()));
}

/// How often a topic was published anew, as diagnostics tell.
fn held_up(said: &Diagnostics) -> u64 {
    let values = said.status[0].values.iter();
    let count = values.filter(|(key, _)| key == "held_up").find_map(|(_, count)| count.parse().ok());
    count.unwrap_or(0)
}

#[test]
fn who_does_not_read_does_not_hold_up_the_others() {
    if no_network() || skipped() || too_long("a subscriber that does not read") {
        return;
    }
    let environment = domain();
    let mut peer = listener(&environment);
    let filtered = "/limpid/depth_filtered/image";
    peer.listen(9, filtered, "sensor_msgs/msg/Image", Quality::Stream { depth: 100 });
    // One that never takes what it is given, and one whose process stands still: a second node on the filtered depth.
    let never = Peer::join(&environment);
    let kind = "nav2_msgs/msg/Costmap";
    let untouched =
        never.participant.subscribe("/limpid/costmap_raw", kind, Quality::Stream { depth: 1 }).unwrap();
    let node = Node::start(&environment, node_options(eye()));
    let depth = format!("depth_topic:={filtered}");
    let second = ["node", "--method", "range", "--ros-args", "-r", "__node:=second", "-p", &depth];
    let second = Process::limpid(&environment, &[&second[..], &["-p", "reliable_sensors:=true"]].concat());
    let robot = Robot::start(&environment, Script { rate_hz: 60.0, ..Script::default() }, false);
    peer.wait_for_topic("/second/costmap");
    peer.wait_for::<Costs>(RAW, free);
    // It reads by now.
    std::thread::sleep(Duration::from_secs(2));
    second.signal("-STOP");
    let began = Instant::now();
    // What is kept for it fills; then those who listen go on all the same.
    peer.wait_for::<Diagnostics>(DIAGNOSTICS, |said| held_up(said) > 0);
    let filled = began.elapsed();
    while peer.next(Instant::now()).is_some() {}
    let began = Instant::now();
    let (mut images, mut maps) = (0, 0);
    let mut whole = [None, None];
    while images < 30 || maps < 10 {
        assert!(began.elapsed() < PATIENCE, "{images} images and {maps} maps");
        match peer.next(Instant::now() + Duration::from_millis(100)) {
            Some((9, _)) => images += 1,
            Some((RAW, _)) => maps += 1,
            _ => {}
        }
        for (at, reached) in whole.iter_mut().zip([images >= 30, maps >= 10]) {
            if reached && at.is_none() {
                *at = Some(began.elapsed().as_secs_f64());
            }
        }
    }
    say(&format!(
        "a reader stands still: its writer is replaced after {:.1} s, then 30 images in {:.1} s, 10 maps in {:.1} s",
        filled.as_secs_f64(),
        whole[0].unwrap_or_default(),
        whole[1].unwrap_or_default()
    ));
    drop((robot, untouched));
    node.end();
}

/// Two network namespaces with a cable between them; `None`, said aloud, where that is not allowed.
struct Cable {
    names: [String; 2],
}

impl Cable {
    fn lay() -> Option<Self> {
        let id = std::process::id() % 10_000;
        let cable = Self { names: ["a", "b"].map(|end| format!("limpid-{end}{id}")) };
        let [a, b] = &cable.names;
        let ends = [format!("lima{id}"), format!("limb{id}")];
        let laid = ip(&["netns", "add", a])
            && ip(&["netns", "add", b])
            && ip(&[
                "link", "add", &ends[0], "netns", a, "type", "veth", "peer", "name", &ends[1], "netns", b,
            ])
            && [(a, &ends[0], "10.77.0.1/24"), (b, &ends[1], "10.77.0.2/24")].iter().all(
                |(name, end, address)| {
                    ip(&["-n", name, "address", "add", address, "dev", end])
                        && ip(&["-n", name, "link", "set", end, "up", "multicast", "on"])
                        && ip(&["-n", name, "link", "set", "lo", "up"])
                        && ip(&["-n", name, "route", "add", "224.0.0.0/4", "dev", end])
                },
            );
        if laid {
            return Some(cable);
        }
        say("skipped: a peer that leaves the network: network namespaces are not allowed here");
        None
    }

    fn set(&self, state: &str) {
        let id = self.names[0].trim_start_matches("limpid-a");
        assert!(ip(&["-n", &self.names[0], "link", "set", &format!("lima{id}"), state]));
        if state == "up" {
            // Routes go with the link.
            assert!(ip(&[
                "-n",
                &self.names[0],
                "route",
                "replace",
                "224.0.0.0/4",
                "dev",
                &format!("lima{id}")
            ]));
        }
    }

    fn limpid(&self, end: usize, environment: &Environment, arguments: &[&str]) -> Process {
        let mut command = Command::new("ip");
        command.args(["netns", "exec", &self.names[end], env!("CARGO_BIN_EXE_limpid")]).args(arguments);
        Process::start(command, environment)
    }
}

impl Drop for Cable {
    fn drop(&mut self) {
        self.names.iter().for_each(|name| {
            ip(&["netns", "delete", name]);
        });
    }
}

fn ip(arguments: &[&str]) -> bool {
    Command::new("ip").args(arguments).stderr(Stdio::null()).status().is_ok_and(|status| status.success())
}

#[test]
fn a_camera_that_leaves_the_network_and_comes_back() {
    if skipped() || too_long("a camera that leaves the network") {
        return;
    }
    let Some(cable) = Cable::lay() else { return };
    let environment = Environment { domain: 3, ..Environment::default() };
    let folder = tempfile::tempdir().unwrap();
    let said = std::fs::File::create(folder.path().join("said")).unwrap();
    // The node's own clock says when its map goes stale: it is watched by what it tells.
    let mut command = Command::new("ip");
    let node = ["netns", "exec", &cable.names[0], env!("CARGO_BIN_EXE_limpid"), "node", "--method", "range"];
    command.args(node).args(["--ros-args", "-p", "timeout_s:=0.7"]);
    command.env("ROS_DOMAIN_ID", "3").stdout(said);
    let mut node = Process(command.spawn().unwrap());
    let _player = cable.limpid(1, &environment, &["play", ROOM, "--loop", "--wait", "30"]);
    let text = || std::fs::read_to_string(folder.path().join("said")).unwrap();
    let wait_for = |what: &str, times: usize| {
        let began = Instant::now();
        while text().matches(what).count() < times {
            assert!(began.elapsed() < PATIENCE, "`{what}` was not said:\n{}", text());
            std::thread::sleep(Duration::from_millis(20));
        }
        began.elapsed()
    };
    wait_for("state OK", 1);
    cable.set("down");
    let seen = wait_for("state STALE", 1);
    cable.set("up");
    let well = wait_for("state OK", 2);
    let (seen_s, well_s) = (seen.as_secs_f64(), well.as_secs_f64());
    say(&format!(
        "the peer leaves and rejoins the network: seen after {seen_s:.2} s, well after {well_s:.2} s"
    ));
    node.signal("-TERM");
    let _ = node.0.wait();
}
