//! The node as a process of its own, and a participant that listens to it.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use limpid::message::ros2::{Header, Pose, Time, decode_cdr};
use limpid::ros2::{Environment, Inbox, Participant, Quality};
use limpid::{Error, Result};
use serde::Deserialize;

/// Numbers of what is listened to.
pub(crate) const MAP: u32 = 0;
pub(crate) const UPDATE: u32 = 1;
pub(crate) const RAW: u32 = 2;
pub(crate) const DIAGNOSTICS: u32 = 3;

/// Clock ticks a second of `/proc/PID/stat`.
const TICKS_HZ: f64 = 100.0;

/// What a cost message begins with; `nav2_msgs/Costmap`.
#[derive(Deserialize)]
pub(crate) struct Costs {
    pub(crate) header: Header,
    pub(crate) _map_load_time: Time,
    pub(crate) _update_time: Time,
    pub(crate) _layer: String,
    pub(crate) _resolution: f32,
    pub(crate) _size_x: u32,
    pub(crate) _size_y: u32,
    pub(crate) origin: Pose,
    #[serde(with = "serde_bytes")]
    pub(crate) data: Vec<u8>,
}

/// `diagnostic_msgs/DiagnosticArray`: statuses of level, name, message, device and values.
#[derive(Deserialize)]
pub(crate) struct Diagnostics {
    _header: Header,
    pub(crate) status: Vec<Status>,
}

#[derive(Deserialize)]
pub(crate) struct Status {
    pub(crate) level: u8,
    pub(crate) name: String,
    pub(crate) message: String,
    _device: String,
    pub(crate) values: Vec<(String, String)>,
}

/// A node that runs, and what listens to it.
pub(crate) struct Beside {
    node: Child,
    pub(crate) environment: Environment,
    pub(crate) participant: Participant,
    pub(crate) inbox: Inbox,
}

impl Drop for Beside {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.node.kill();
        let _ = self.node.wait();
    }
}

impl Beside {
    /// Starts a node with these arguments after `limpid node`, in a domain of its own.
    pub(crate) fn start(program: &Path, arguments: &[String]) -> Result<Self> {
        let domain = 1 + u16::try_from(std::process::id() % 100).unwrap_or(0);
        let environment = Environment { domain, localhost_only: true, ..Environment::default() };
        let participant = Participant::join(&environment)?;
        let inbox = Inbox::open()?;
        let stream = Quality::Stream { depth: 100 };
        for (number, name, kind, quality) in [
            (MAP, "/limpid/costmap", "nav_msgs/msg/OccupancyGrid", Quality::Latched { depth: 1 }),
            (UPDATE, "/limpid/costmap_updates", "map_msgs/msg/OccupancyGridUpdate", stream),
            (RAW, "/limpid/costmap_raw", "nav2_msgs/msg/Costmap", Quality::Latched { depth: 100 }),
            (DIAGNOSTICS, "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", stream),
        ] {
            inbox.add(number, participant.subscribe(name, kind, quality)?, 4096, false);
        }
        let mut command = Command::new(program);
        command.arg("node").args(arguments).stdout(Stdio::null());
        command.env("ROS_DOMAIN_ID", domain.to_string()).env("ROS_LOCALHOST_ONLY", "1");
        let node = command.spawn().map_err(Error::file(program))?;
        let beside = Self { node, environment, participant, inbox };
        // A second status means that the node knows who listens.
        for _ in 0..2 {
            beside.wait_for(DIAGNOSTICS)?;
        }
        Ok(beside)
    }

    fn wait_for(&self, topic: u32) -> Result<Vec<u8>> {
        let until = Instant::now() + Duration::from_secs(120);
        while self.inbox.wait(until) {
            if let Some(parcel) = self.inbox.take(None).filter(|parcel| parcel.topic == topic) {
                return Ok(parcel.payload);
            }
        }
        Err(Error::Empty { reason: "the node says nothing".into() })
    }

    /// Resident memory of the node, KiB.
    pub(crate) fn resident_kib(&self) -> u64 {
        let statm = std::fs::read_to_string(format!("/proc/{}/statm", self.node.id())).unwrap_or_default();
        statm.split(' ').nth(1).and_then(|pages| pages.parse::<u64>().ok()).unwrap_or(0) * 4
    }

    /// CPU time of the node so far, seconds.
    pub(crate) fn cpu_s(&self) -> f64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.node.id())).unwrap_or_default();
        let after = stat.rsplit(')').next().unwrap_or_default();
        let ticks = after.split_whitespace().skip(11).take(2).filter_map(|ticks| ticks.parse::<f64>().ok());
        ticks.sum::<f64>() / TICKS_HZ
    }
}

/// What the node says of itself, in a line.
pub(crate) fn said(payload: &[u8]) -> Option<(String, Vec<(String, String)>)> {
    let diagnostics: Diagnostics = decode_cdr("DiagnosticArray", payload).ok()?;
    let values = diagnostics.status.iter().flat_map(|status| {
        let name = status.name.trim_start_matches("limpid: ").to_owned();
        status.values.iter().map(move |(key, value)| (format!("{name}: {key}"), value.clone()))
    });
    let worst = diagnostics.status.iter().max_by_key(|status| status.level)?;
    Some((worst.message.clone(), values.collect()))
}

/// The stamp in front of a message that begins with a header.
pub(crate) fn stamp_ns(payload: &[u8]) -> Option<u64> {
    decode_cdr::<Header>("header", payload).ok()?.stamp.stamp_ns().ok()
}
