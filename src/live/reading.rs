//! From the graph to observations: which topics are read, and what waits to go into the map.

use std::collections::{BTreeMap, VecDeque};
use std::time::{Duration, Instant};

use crate::base::Result;
use crate::config::Config;
use crate::input::{LiveSource, LiveTopic};
use crate::live::NodeOptions;
use crate::ros2::{Graph, GraphTopic, Inbox, Naming, Parcel, Participant, Quality};
use crate::sensor::Observation;

/// Messages of a topic that wait at most; of transforms more, as they come often and are small.
const SENSOR_MOST: usize = 64;
const TRANSFORM_MOST: usize = 4096;

/// Types whose messages are worth nothing once a newer one is there.
const PERISHABLE: [&str; 10] = [
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/CompressedImage",
    "sensor_msgs/msg/PointCloud2",
    "sensor_msgs/msg/PointCloud",
    "sensor_msgs/msg/LaserScan",
    "sensor_msgs/msg/MultiEchoLaserScan",
    "velodyne_msgs/msg/VelodyneScan",
    "livox_ros_driver2/msg/CustomMsg",
    "livox_ros_driver/msg/CustomMsg",
    "livox_interfaces/msg/CustomMsg",
];

/// A message of these that waited longer is dropped where a newer one of its topic waits.
const LONGEST_WAIT: Duration = Duration::from_millis(250);

/// How long a node may take after its start to read what came meanwhile, before age counts: a machine that cannot keep up would
/// else read the oldest of everything for good.
const CATCH_UP: Duration = Duration::from_secs(3);

/// How long the first data of all sensors are waited for after that of one.
const LATE_SENSORS: Duration = Duration::from_secs(3);

/// An observation that waits for the map, and when it was complete.
pub(super) struct Waiting {
    pub(super) observation: Observation,
    pub(super) since: Instant,
}

/// What came out of the messages that were read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Event {
    /// The stamps of a sensor jumped back: the map is to begin anew.
    Jumped,
    /// An observation of a sensor has no pose.
    WithoutPose(usize),
    /// An observation of a sensor is of the time before its stamps jumped back.
    BeforeJump(usize),
}

/// See the module.
pub(super) struct Reading {
    pub(super) source: LiveSource,
    /// Readers, for the graph.
    pub(super) readers: Vec<[u8; 16]>,
    /// Full name, type and quality of what is subscribed to.
    subscribed: Vec<(String, String, Quality)>,
    pub(super) waiting: VecDeque<Waiting>,
    generation: u32,
    first: Option<Instant>,
    start: Start,
}

/// Whether what came while the passes were built is read first; then nothing is dropped for its age.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Start {
    /// There are no passes.
    Unbuilt,
    /// It catches up, until then at most.
    CatchingUp(Instant),
    Over,
}

impl Start {
    /// At a time when there are passes.
    fn with_passes(self, now: Instant) -> Self {
        match self {
            Self::Unbuilt => Self::CatchingUp(now + CATCH_UP),
            Self::CatchingUp(until) if now >= until => Self::Over,
            unchanged => unchanged,
        }
    }

    /// Nothing is left to read.
    fn emptied(self) -> Self {
        if self == Self::Unbuilt { self } else { Self::Over }
    }
}

impl Reading {
    /// Subscribes to what a source reads.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn open(
        source: LiveSource,
        options: &NodeOptions,
        (participant, inbox, graph): (&Participant, &Inbox, &Graph),
    ) -> Result<Self> {
        let (mut readers, mut subscribed) = (Vec::new(), Vec::new());
        for topic in source.topics() {
            let name = options.naming.resolve(&topic.name)?;
            let (quality, most) = quality_of(topic, graph.topic(&name), &options.config);
            let perishable = PERISHABLE.contains(&topic.type_name.as_str());
            let subscription = participant.subscribe(&name, &topic.type_name, quality)?;
            readers.push(subscription.guid());
            inbox.add(topic.number, subscription, most, perishable);
            subscribed.push((name, topic.type_name.clone(), quality));
        }
        let waiting = VecDeque::new();
        Ok(Self { source, readers, subscribed, waiting, generation: 0, first: None, start: Start::Unbuilt })
    }

    /// Receives no more.
    pub(super) fn close(&self, inbox: &Inbox) {
        self.source.topics().iter().for_each(|topic| inbox.remove(topic.number));
    }

    /// Why some of what others publish does not come in.
    pub(super) fn unheard(&self, graph: &Graph) -> Vec<String> {
        let subscribed = self.subscribed.iter();
        subscribed.flat_map(|(name, kind, quality)| graph.unheard(name, kind, *quality)).collect()
    }

    /// The passes begin anew.
    pub(super) fn begin_anew(&mut self) {
        self.start = Start::Unbuilt;
    }

    /// The passes are there.
    pub(super) fn built(&mut self, now: Instant) {
        self.start = self.start.with_passes(now);
    }

    /// All that came is read.
    pub(super) fn emptied(&mut self) {
        self.start = self.start.emptied();
    }

    /// Messages that waited longer are dropped for newer ones.
    pub(super) fn longest_wait(&self) -> Option<Duration> {
        (self.start == Start::Over).then_some(LONGEST_WAIT)
    }

    /// Whether more may be read: not while enough waits for the map.
    pub(super) fn has_room(&self) -> bool {
        let most = if self.start != Start::Over { SENSOR_MOST } else { 2 * self.source.sensors().len() };
        self.waiting.len() < most
    }

    /// Reads a message.
    pub(super) fn take(&mut self, parcel: &Parcel, came_ns: u64, now: Instant, tell: &mut dyn FnMut(Event)) {
        self.source.push(parcel.topic, came_ns, &parcel.payload);
        self.collect(now, tell);
    }

    /// Moves on what has waited long enough.
    pub(super) fn tell_time(&mut self, steady_ns: u64, now: Instant, tell: &mut dyn FnMut(Event)) {
        self.source.tell_time(steady_ns);
        self.collect(now, tell);
    }

    fn collect(&mut self, now: Instant, tell: &mut dyn FnMut(Event)) {
        while let Some((jumps, observation)) = self.source.poll() {
            if jumps > self.generation {
                self.generation = jumps;
                let before = self.waiting.drain(..);
                before.for_each(|waiting| tell(Event::BeforeJump(waiting.observation.sensor)));
                tell(Event::Jumped);
            }
            if jumps < self.generation {
                tell(Event::BeforeJump(observation.sensor));
            } else if observation.pose.is_none() {
                tell(Event::WithoutPose(observation.sensor));
            } else {
                self.first.get_or_insert(now);
                self.waiting.push_back(Waiting { observation, since: now });
            }
        }
    }

    /// Leaves out the sensors that were found by their topics and gave nothing that can be used, where another did.
    pub(super) fn leave_out_missing(&mut self) {
        for at in self.source.leave_out_missing().into_iter().rev() {
            self.waiting.iter_mut().filter(|waiting| waiting.observation.sensor > at).for_each(|waiting| {
                waiting.observation.sensor -= 1;
            });
        }
    }

    /// Whether the passes can be built: all sensors are known, or one is and the others are late.
    pub(super) fn is_ready(&self, now: Instant) -> bool {
        self.first.is_some_and(|first| {
            self.source.knows_all() || now.saturating_duration_since(first) > LATE_SENSORS
        })
    }
}

/// How a topic is subscribed to, as its publishers offer it, and how many of its messages may wait.
fn quality_of(topic: &LiveTopic, offered: Option<&GraphTopic>, config: &Config) -> (Quality, usize) {
    let reliable = offered.is_some_and(|topic| topic.reliable);
    let latched = offered.is_some_and(|topic| topic.latched);
    if topic.type_name == "tf2_msgs/msg/TFMessage" {
        let fixed = topic.name.contains("static");
        // Nothing is known of a topic that nobody publishes any more: then as ROS says it should be.
        let quality = match (offered.is_none() || reliable, fixed && (offered.is_none() || latched)) {
            (true, true) => Quality::Latched { depth: 1000 },
            (true, false) => Quality::Stream { depth: 1000 },
            (false, _) => Quality::Sensor,
        };
        return (quality, TRANSFORM_MOST);
    }
    let quality = if config.reliable_sensors && reliable { Quality::SensorReliable } else { Quality::Sensor };
    (quality, SENSOR_MOST)
}

/// What a node that finds no sensor tells after a while.
pub(super) fn hint(naming: &Naming, known: &BTreeMap<String, String>, what: &str) -> String {
    let mut names: Vec<_> = known.keys().map(String::as_str).collect();
    let more = names.len().saturating_sub(20);
    names.truncate(20);
    let listing = match (names.is_empty(), more) {
        (true, _) => "nobody publishes anything that it sees: is it the same ROS_DOMAIN_ID?".to_owned(),
        (false, 0) => format!("topics that it sees: {}", names.join(", ")),
        (false, more) => format!("topics that it sees: {} and {more} more", names.join(", ")),
    };
    format!("{} still waits: {what}; {listing}", naming.full_name())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn age_counts_once_all_is_read_or_reading_it_takes_too_long() {
        let now = Instant::now();
        assert_eq!(Start::Unbuilt.emptied(), Start::Unbuilt, "what comes while passes are built is kept");
        let catching_up = Start::Unbuilt.with_passes(now);
        assert_eq!(catching_up.with_passes(now + CATCH_UP / 2), catching_up);
        assert_eq!(catching_up.emptied(), Start::Over);
        assert_eq!(catching_up.with_passes(now + CATCH_UP), Start::Over);
        assert_eq!(Start::Over.with_passes(now), Start::Over);
    }
}
