//! The observations of a live graph: the pairing, transforms and refusals of recordings, with messages that come by
//! themselves and waits that are bounded by the clock.

use crate::base::{Result, duration_ns};
use crate::config::{Config, SensorInfo};
use crate::input::log::Record;
use crate::input::log::source::LogSource;
use crate::input::log::topics::Channels;
use crate::input::source::{Source, SourceReport};
use crate::sensor::Observation;

/// A topic of the graph that is read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct LiveTopic {
    /// Number that its messages are pushed under.
    pub(crate) number: u32,
    /// Full name.
    pub(crate) name: String,
    /// As in `sensor_msgs/msg/Image`.
    pub(crate) type_name: String,
}

/// See the module.
pub(crate) struct LiveSource {
    source: LogSource,
    topics: Vec<LiveTopic>,
    patience_ns: u64,
}

impl LiveSource {
    /// Chooses what is read of the topics that `graph` has (name and type): those of the sensors that the configuration
    /// names, else a camera and a lidar that are found by type and name. `place` names the graph in messages to the user.
    ///
    /// # Errors
    /// As for a recording: [`crate::Error::Format`] where there is no sensor that can be read; [`crate::Error::Config`] for a
    /// configured topic that is absent or of another type, with the nearest names.
    pub(crate) fn choose(place: &str, graph: &[(String, String)], config: &Config) -> Result<Self> {
        let mut channels = Channels::default();
        for (id, (topic, type_name)) in (0..).zip(graph) {
            let (topic, type_name, message_encoding) = (topic.clone(), type_name.clone(), "cdr".into());
            channels.learn(Record::Topic { id, topic, type_name, message_encoding });
        }
        let mut source = LogSource::live(place, channels, config)?;
        let wanted = (0..).zip(graph).filter(|(number, _)| source.log().wants(*number));
        let topic = |(number, (name, type_name)): (u32, &(String, String))| LiveTopic {
            number,
            name: name.clone(),
            type_name: type_name.clone(),
        };
        let topics = wanted.map(topic).collect();
        Ok(Self { source, topics, patience_ns: duration_ns(config.wait_s) })
    }

    /// Waits as long as a configuration says.
    pub(crate) fn set_patience(&mut self, config: &Config) {
        self.patience_ns = duration_ns(config.wait_s);
    }

    /// The topics that are read.
    pub(crate) fn topics(&self) -> &[LiveTopic] {
        &self.topics
    }

    /// The sensors as far as they are known; those of which nothing came are missing.
    pub(crate) fn sensors(&self) -> &[SensorInfo] {
        self.source.sensors()
    }

    /// Whether the sensors are known as well as can be.
    pub(crate) fn knows_all(&self) -> bool {
        self.source.knows_all()
    }

    /// Leaves out the sensors that were found by type and gave nothing, where another did; which they were. Those that the
    /// configuration names stay.
    pub(crate) fn leave_out_missing(&mut self) -> Vec<usize> {
        self.source.leave_out_found()
    }

    /// Names of the sensors whose topics nobody publishes.
    pub(crate) fn absent(&self) -> Vec<String> {
        self.source.absent().map(str::to_owned).collect()
    }

    /// Whether somebody publishes transforms or the odometry that is configured.
    pub(crate) fn has_motion(&mut self) -> bool {
        self.source.log().is_motion_recorded()
    }

    /// Takes a message that came at `now_ns` of a clock that never jumps.
    pub(crate) fn push(&mut self, topic: u32, now_ns: u64, payload: &[u8]) {
        let patience_ns = self.patience_ns;
        self.source.log().push(topic, now_ns, payload, patience_ns);
    }

    /// Moves on what has waited long enough.
    pub(crate) fn tell_time(&mut self, now_ns: u64) {
        let patience_ns = self.patience_ns;
        self.source.log().settle_at(now_ns, patience_ns);
    }

    /// The next observation, with the number of times that its sensor's stamps had jumped back before it.
    pub(crate) fn poll(&mut self) -> Option<(u32, Observation)> {
        self.source.poll()
    }

    /// What was met so far.
    pub(crate) fn report(&self) -> SourceReport {
        self.source.report()
    }
}
