//! A node tried out on one machine: a recording is played into it over the loopback network, and a third participant listens.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use serde::Deserialize;

use crate::base::{Error, Result};
use crate::config::Config;
use crate::input::playback::Playback;
use crate::live::node::{NodeOptions, run_node};
use crate::live::play::{PlayOptions, play};
use crate::live::stop::Stop;
use crate::map::Grid;
use crate::message::ros2::{Header, Pose, Time, decode_cdr};
use crate::output::png::save_costs;
use crate::ros2::{Environment, Inbox, Naming, Participant, Quality};

/// Numbers of what is listened to; other numbers are sensors' topics.
const RAW: u32 = u32::MAX;
const UPDATE: u32 = u32::MAX - 1;
const MAP: u32 = u32::MAX - 2;

/// Types of what sensors see.
const SEEN: [&str; 2] = ["sensor_msgs/msg/Image", "sensor_msgs/msg/PointCloud2"];

/// Stamps that go back by more begin another round, nanoseconds.
const JUMP_NS: u64 = 1_000_000_000;

const MANY: Quality = Quality::Stream { depth: 1000 };

/// Longest wait for the passes to be built.
const LONGEST_BUILD: Duration = Duration::from_secs(60);

/// How long the trial waits for maps after the recording has ended.
const PATIENCE: Duration = Duration::from_secs(20);

/// What a trial has shown.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Trial {
    /// Messages played.
    pub sent: u64,
    /// Maps with free cells that came.
    pub maps: usize,
    /// From the arrival of a sensor's data to that of the map with it, milliseconds, ascending.
    pub latencies_ms: Vec<f64>,
}

impl Trial {
    /// The value that a share of the latencies is not above.
    fn at(&self, share: f64) -> f64 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            clippy::cast_precision_loss,
            reason = "an index; casts saturate"
        )]
        let index = (share * self.latencies_ms.len() as f64) as usize;
        self.latencies_ms.get(index).or(self.latencies_ms.last()).copied().unwrap_or(f64::NAN)
    }

    /// A table in Markdown.
    pub fn table(&self) -> String {
        let mut table =
            String::from("| messages played | maps with free floor | median ms | p90 ms | longest ms |\n");
        table += "|---|---|---|---|---|\n";
        let [median, p90, longest] = [0.5, 0.9, 1.0].map(|share| self.at(share));
        // Writing into a String cannot fail.
        let _ = writeln!(
            table,
            "| {} | {} | {median:.1} | {p90:.1} | {longest:.1} |\n\n\
             From the arrival of a sensor's data at a subscriber of this machine to the arrival of the map that holds them;\n\
             {} maps, those of data that came after the passes were built.",
            self.sent,
            self.maps,
            self.latencies_ms.len()
        );
        table
    }
}

/// What a cost message begins with; `nav2_msgs/Costmap`.
#[derive(Deserialize)]
struct Costs {
    _header: Header,
    _map_load_time: Time,
    _update_time: Time,
    _layer: String,
    resolution: f32,
    size_x: u32,
    size_y: u32,
    origin: Pose,
    #[serde(with = "serde_bytes")]
    data: Vec<u8>,
}

/// Plays `recording` into a node with these parameters, in the domain of `environment`; the last map with free cells goes to `picture`.
///
/// # Errors
/// What [`run_node`] and [`play`] return; [`Error::Empty`] where no map comes.
pub fn try_node(
    recording: &Path,
    (config, adapter): (&Config, Option<&str>),
    environment: &Environment,
    picture: &Path,
    say: &mut (dyn FnMut(&str) + Send),
) -> Result<Trial> {
    let watcher = Watcher::open(recording, config, environment)?;
    let (stop, mapped, played) = (Stop::default(), Stop::default(), Stop::default());
    let options = NodeOptions {
        config: config.clone(),
        adapter: adapter.map(str::to_owned),
        naming: Naming::new("limpid", "/", &[])?,
        foxglove: None,
        context: None,
    };
    let player = PlayOptions {
        rate: 1.0,
        again: false,
        clock_hz: None,
        start_s: 0.0,
        wait_s: 60.0,
        reliable: true,
        naming: Naming::new("limpid_play", "/", &[])?,
    };
    thread::scope(|scope| {
        let node = scope.spawn(|| run_node(&options, environment, &stop, say));
        let recorded = scope.spawn(|| {
            // Once for the passes to be built, once to be measured.
            let round = || play(recording, config, &player, environment, &stop, &mut |_| ());
            let first = round();
            mapped.sleep(Instant::now() + LONGEST_BUILD);
            let report = first.and_then(|_| round());
            played.set();
            report
        });
        let seen = watcher.watch(&mapped, &played, || node.is_finished());
        stop.set();
        let sent = recorded.join().map_err(|_| panicked())??.sent;
        node.join().map_err(|_| panicked())??;
        let (last, latencies_ms, maps) = seen?;
        save(picture, &last)?;
        Ok(Trial { sent, maps, latencies_ms })
    })
}

fn panicked() -> Error {
    Error::Ros2 { what: "the trial".into(), reason: "a part of it panicked".into() }
}

fn save(picture: &Path, costs: &Costs) -> Result<()> {
    let grid = Grid {
        origin_x_m: costs.origin.position.x,
        origin_y_m: costs.origin.position.y,
        resolution_m: f64::from(costs.resolution),
        width: costs.size_x,
        height: costs.size_y,
    };
    save_costs(picture, &grid, &costs.data)
}

/// Who listens.
struct Watcher {
    participant: Participant,
    inbox: Inbox,
    /// Names and types of topics with what sensors see.
    sensors: Vec<(String, String)>,
}

impl Watcher {
    fn open(recording: &Path, config: &Config, environment: &Environment) -> Result<Self> {
        let participant = Participant::join(environment)?;
        let inbox = Inbox::open()?;
        let playback = Playback::open(recording, config)?;
        let seen = playback.topics().iter().filter(|topic| SEEN.contains(&topic.type_name.as_str()));
        let sensors = seen.map(|topic| (topic.name.clone(), topic.type_name.clone())).collect();
        let latched = Quality::Latched { depth: 100 };
        for (number, name, kind, quality) in [
            (RAW, "/limpid/costmap_raw", "nav2_msgs/msg/Costmap", latched),
            (UPDATE, "/limpid/costmap_updates", "map_msgs/msg/OccupancyGridUpdate", MANY),
            (MAP, "/limpid/costmap", "nav_msgs/msg/OccupancyGrid", latched),
        ] {
            inbox.add(number, participant.subscribe(name, kind, quality)?, 4096, false);
        }
        Ok(Self { participant, inbox, sensors })
    }

    /// Listens to the sensors as soon as the node does, as the player waits for one who listens; whether that is so.
    fn listen_to_sensors(&self) -> Result<bool> {
        let graph = self.participant.graph();
        if !self.sensors.iter().any(|(name, _)| graph.listeners(name) > 0) {
            return Ok(false);
        }
        for (number, (name, kind)) in (0..).zip(&self.sensors) {
            self.inbox.add(number, self.participant.subscribe(name, kind, MANY)?, 4096, false);
        }
        Ok(true)
    }

    /// Watches until the map has no free cell any more after the recording has ended: its last map with some, latencies, and how many
    /// maps of the second round there were.
    fn watch(
        &self,
        mapped: &Stop,
        played: &Stop,
        has_failed: impl Fn() -> bool,
    ) -> Result<(Costs, Vec<f64>, usize)> {
        let (mut arrived, mut latencies) = (HashMap::<u64, Instant>::new(), Vec::new());
        let (mut last, mut maps) = (None, 0);
        let (mut until, mut listens, mut newest_ns, mut built) = (None, false, 0, None);
        while !has_failed() && until.is_none_or(|until| Instant::now() < until) {
            if played.is_set() {
                until.get_or_insert(Instant::now() + PATIENCE);
            }
            listens = listens || self.listen_to_sensors()?;
            self.inbox.wait(Instant::now() + Duration::from_millis(50));
            let Some(parcel) = self.inbox.take(None) else { continue };
            let stamp = decode_cdr::<Header>("header", &parcel.payload)?.stamp.stamp_ns()?;
            match parcel.topic {
                RAW => {
                    let costs: Costs = decode_cdr("Costmap", &parcel.payload)?;
                    built.get_or_insert(parcel.arrived);
                    mapped.set();
                    if costs.data.contains(&0) {
                        maps += 1;
                        last = Some(costs);
                    } else if played.is_set() && stamp >= newest_ns {
                        break;
                    }
                }
                MAP | UPDATE => {
                    // What came before the first map waited for the passes to be built.
                    let since =
                        arrived.remove(&stamp).filter(|since| built.is_some_and(|built| *since > built));
                    latencies.extend(since.map(|since| (parcel.arrived - since).as_secs_f64() * 1e3));
                }
                _ => {
                    if stamp + JUMP_NS < newest_ns {
                        // The second round.
                        (maps, newest_ns, built) = (0, 0, None);
                        arrived.clear();
                        latencies.clear();
                    }
                    newest_ns = newest_ns.max(stamp);
                    arrived.insert(stamp, parcel.arrived);
                }
            }
        }
        let last = last.ok_or(Error::Empty { reason: "no map with free cells came".into() })?;
        let mut latencies_ms: Vec<f64> = latencies;
        latencies_ms.sort_by(f64::total_cmp);
        Ok((last, latencies_ms, maps))
    }
}
