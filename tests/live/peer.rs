//! A peer in the graph of a test: listens, publishes, waits within bounds.

use std::sync::atomic::{AtomicU16, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use limpid::live::{NodeOptions, PlayOptions, PlayReport, Stop, play, run_node};
use limpid::message::ros2::{Header, Pose, Time, decode_cdr};
use limpid::ros2::{Environment, Inbox, Naming, Participant, Quality};
use limpid::{Config, Result};
use serde::Deserialize;

use crate::support::say;

/// Longest wait for anything; a loaded machine of two cores is slow, a test that hangs is worse.
pub(super) const PATIENCE: Duration = Duration::from_secs(60);

/// Whole map, `nav_msgs/OccupancyGrid`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct Occupancy {
    pub(super) header: Header,
    pub(super) map_load_time: Time,
    pub(super) resolution: f32,
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) origin: Pose,
    #[serde(with = "serde_bytes")]
    pub(super) data: Vec<u8>,
}

/// `map_msgs/OccupancyGridUpdate`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct Update {
    pub(super) header: Header,
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) width: u32,
    pub(super) height: u32,
    #[serde(with = "serde_bytes")]
    pub(super) data: Vec<u8>,
}

/// `nav2_msgs/Costmap`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct Costs {
    pub(super) header: Header,
    pub(super) map_load_time: Time,
    pub(super) update_time: Time,
    pub(super) layer: String,
    pub(super) resolution: f32,
    pub(super) size_x: u32,
    pub(super) size_y: u32,
    pub(super) origin: Pose,
    #[serde(with = "serde_bytes")]
    pub(super) data: Vec<u8>,
}

/// `diagnostic_msgs/DiagnosticArray`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct Diagnostics {
    pub(super) header: Header,
    pub(super) status: Vec<Status>,
}

#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct Status {
    pub(super) level: u8,
    pub(super) name: String,
    pub(super) message: String,
    pub(super) hardware_id: String,
    pub(super) values: Vec<(String, String)>,
}

/// `nav2_msgs/SpeedLimit`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct SpeedLimit {
    pub(super) header: Header,
    pub(super) percentage: bool,
    pub(super) speed_limit: f64,
}

/// A domain that no other test of this process has, on this machine alone. Domains above 100 have ports that others may take.
pub(super) fn domain() -> Environment {
    static NEXT: AtomicU16 = AtomicU16::new(0);
    let own = u16::try_from(std::process::id() % 20).unwrap_or(0) * 5;
    Environment {
        domain: 1 + own + NEXT.fetch_add(1, Ordering::Relaxed) % 5,
        localhost_only: true,
        ..Environment::default()
    }
}

/// Whether the loopback network does not carry DDS, said aloud.
pub(super) fn no_network() -> bool {
    static CARRIES: OnceLock<bool> = OnceLock::new();
    let carries = *CARRIES.get_or_init(|| {
        let environment = domain();
        let pair =
            || -> Result<(Peer, Peer)> { Ok((Peer::try_join(&environment)?, Peer::try_join(&environment)?)) };
        let Ok((one, mut other)) = pair() else { return false };
        let publication =
            one.participant.publish("/echo", "std_msgs/msg/String", Quality::Latched { depth: 1 }).unwrap();
        other.listen(0, "/echo", "std_msgs/msg/String", Quality::Latched { depth: 1 });
        publication.send(vec![0, 1, 0, 0, 2, 0, 0, 0, b'a', 0]).unwrap();
        other.next(Instant::now() + Duration::from_secs(20)).is_some()
    });
    if !carries {
        say("skipped: tests of live: the loopback network does not carry DDS here");
    }
    !carries
}

/// See the module.
pub(super) struct Peer {
    pub(super) participant: Participant,
    pub(super) inbox: Inbox,
}

impl Peer {
    pub(super) fn join(environment: &Environment) -> Self {
        Self::try_join(environment).unwrap()
    }

    fn try_join(environment: &Environment) -> Result<Self> {
        Ok(Self { participant: Participant::join(environment)?, inbox: Inbox::open()? })
    }

    /// Listens to a topic under a number.
    pub(super) fn listen(&mut self, number: u32, topic: &str, type_name: &str, quality: Quality) {
        let subscription = self.participant.subscribe(topic, type_name, quality).unwrap();
        self.inbox.add(number, subscription, 100_000, false);
    }

    /// The next message, with the number of its topic.
    pub(super) fn next(&self, until: Instant) -> Option<(u32, Vec<u8>)> {
        self.inbox.wait(until);
        self.inbox.take(None).map(|parcel| (parcel.topic, parcel.payload))
    }

    /// Waits until somebody publishes a topic.
    #[track_caller]
    pub(super) fn wait_for_topic(&self, name: &str) {
        let until = Instant::now() + PATIENCE;
        while self.participant.graph().topic(name).is_none() {
            assert!(Instant::now() < until, "nobody publishes {name}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// The first message of a topic that fits; others are passed over.
    #[track_caller]
    pub(super) fn wait_for<T: serde::de::DeserializeOwned>(
        &self,
        number: u32,
        fits: impl Fn(&T) -> bool,
    ) -> T {
        let until = Instant::now() + PATIENCE;
        while let Some((topic, payload)) = self.next(until) {
            if topic == number {
                let message = decode_cdr::<T>("message", &payload).unwrap();
                if fits(&message) {
                    return message;
                }
            }
        }
        panic!("no message that fits within {} s", PATIENCE.as_secs());
    }
}

/// A node that runs beside the test.
pub(super) struct Node {
    stop: Stop,
    thread: Option<JoinHandle<Result<()>>>,
    lines: Arc<Mutex<Vec<String>>>,
}

impl Node {
    pub(super) fn start(environment: &Environment, options: NodeOptions) -> Self {
        let (stop, lines) = (Stop::default(), Arc::new(Mutex::new(Vec::new())));
        let (own_stop, own_lines, environment) = (stop.clone(), Arc::clone(&lines), environment.clone());
        let thread = std::thread::spawn(move || {
            run_node(&options, &environment, &own_stop, &mut |line| {
                own_lines.lock().unwrap().push(line.to_owned())
            })
        });
        Self { stop, thread: Some(thread), lines }
    }

    /// How many lines hold `text` so far.
    pub(super) fn count(&self, text: &str) -> usize {
        self.lines.lock().unwrap().iter().filter(|line| line.contains(text)).count()
    }

    /// The first line that holds `text`.
    #[cfg(feature = "foxglove")]
    #[track_caller]
    pub(super) fn said(&self, text: &str) -> String {
        self.wait_for(text, 1);
        self.lines.lock().unwrap().iter().find(|line| line.contains(text)).unwrap().clone()
    }

    /// Waits until a line holds `text`, so many times in all.
    #[track_caller]
    pub(super) fn wait_for(&self, text: &str, times: usize) {
        let until = Instant::now() + PATIENCE;
        while self.count(text) < times {
            let said = self.lines.lock().unwrap().clone();
            assert!(Instant::now() < until, "`{text}` was not said: {said:#?}");
            assert!(!self.thread.as_ref().unwrap().is_finished(), "it ended: {said:#?}");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Asks for the end and waits for it; how long it took.
    #[track_caller]
    pub(super) fn end(mut self) -> Duration {
        let asked = Instant::now();
        self.stop.set();
        self.thread.take().unwrap().join().unwrap().unwrap();
        asked.elapsed()
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        self.stop.set();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

pub(super) fn naming(node: &str) -> Naming {
    Naming::new(node, "/", &[]).unwrap()
}

pub(super) fn node_options(config: Config) -> NodeOptions {
    NodeOptions { config, adapter: None, naming: naming("limpid"), foxglove: None, context: None }
}

pub(super) fn play_options() -> PlayOptions {
    PlayOptions {
        rate: 1.0,
        again: false,
        clock_hz: None,
        start_s: 0.0,
        wait_s: PATIENCE.as_secs_f64(),
        reliable: true,
        naming: naming("play"),
    }
}

/// Plays a recording to its end.
pub(super) fn played(environment: &Environment, path: &str, options: &PlayOptions) -> Result<PlayReport> {
    play(path.as_ref(), &Config::default(), options, environment, &Stop::default(), &mut |_| ())
}
