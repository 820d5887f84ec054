//! What others publish and listen to, as discovery has found it.

use rustdds::policy::{Durability, Reliability};
use rustdds::{QosPolicies, RTPSEntity};

use crate::ros2::name::{topic_of_dds, type_of_dds};
use crate::ros2::qos::Quality;

/// A topic that somebody else publishes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GraphTopic {
    /// Full name.
    pub name: String,
    /// As in `sensor_msgs/msg/Image`; those of several publishers that do not agree, each once.
    pub types: Vec<String>,
    /// Publishers.
    pub writers: usize,
    /// Whether all of them are reliable.
    pub reliable: bool,
    /// Whether all of them give what came before to those who come late.
    pub latched: bool,
}

/// A publisher or a subscriber of another participant.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Endpoint {
    /// Full name of its topic.
    topic: String,
    type_name: String,
    /// What it offers, or asks for.
    reliable: bool,
    latched: bool,
}

impl Endpoint {
    fn new(dds_topic: &str, dds_type: &str, qualities: &QosPolicies) -> Option<Self> {
        Some(Self {
            topic: topic_of_dds(dds_topic)?.to_owned(),
            type_name: type_of_dds(dds_type),
            reliable: matches!(qualities.reliability(), Some(Reliability::Reliable { .. })),
            latched: !matches!(qualities.durability(), None | Some(Durability::Volatile)),
        })
    }

    fn quality(&self) -> &'static str {
        match (self.reliable, self.latched) {
            (true, true) => "reliable and transient local",
            (true, false) => "reliable and volatile",
            (false, true) => "best effort and transient local",
            (false, false) => "best effort and volatile",
        }
    }
}

/// A moment's view of the graph.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Graph {
    /// By name.
    pub topics: Vec<GraphTopic>,
    writers: Vec<Endpoint>,
    readers: Vec<Endpoint>,
}

impl Graph {
    pub(super) fn of(dds: &rustdds::DomainParticipant) -> Self {
        let mut graph = Self::default();
        // Where multicast comes back to its sender, discovery finds what is this participant's own.
        let own = dds.guid().prefix;
        for writer in dds.discovered_writers() {
            if writer.writer_proxy.remote_writer_guid.prefix == own {
                continue;
            }
            let data = &writer.publication_topic_data;
            graph.writers.extend(Endpoint::new(&data.topic_name, &data.type_name, &data.qos()));
        }
        for reader in dds.discovered_readers() {
            if reader.reader_proxy.remote_reader_guid.prefix == own {
                continue;
            }
            let data = &reader.subscription_topic_data;
            graph.readers.extend(Endpoint::new(data.topic_name(), data.type_name(), &data.qos()));
        }
        graph.gather();
        graph
    }

    /// Makes the topics of the publishers.
    fn gather(&mut self) {
        for Endpoint { topic: name, type_name, reliable, latched } in &self.writers {
            match self.topics.iter_mut().find(|topic| topic.name == *name) {
                Some(topic) => {
                    topic.writers += 1;
                    topic.reliable &= reliable;
                    topic.latched &= latched;
                    if !topic.types.contains(type_name) {
                        topic.types.push(type_name.clone());
                    }
                }
                None => self.topics.push(GraphTopic {
                    name: name.clone(),
                    types: vec![type_name.clone()],
                    writers: 1,
                    reliable: *reliable,
                    latched: *latched,
                }),
            }
        }
        self.topics.sort_by(|a, b| a.name.cmp(&b.name));
    }

    /// Why what others publish on a topic does not reach one who subscribes to it like this; each reason once.
    pub fn unheard(&self, name: &str, type_name: &str, asked: Quality) -> Vec<String> {
        let mut reasons = Vec::new();
        for writer in self.writers.iter().filter(|writer| writer.topic == name) {
            let quality = writer.quality();
            let reason = if writer.type_name != type_name {
                format!("{name} is read as {type_name}, but somebody publishes {} there", writer.type_name)
            } else if asked.is_reliable() && !writer.reliable || asked.is_latched() && !writer.latched {
                format!("{name} is read as {}, but somebody publishes it as {quality}", asked.name())
            } else {
                continue;
            };
            if !reasons.contains(&reason) {
                reasons.push(reason);
            }
        }
        reasons
    }

    /// Why others who subscribe to a topic do not hear one who publishes it like this; each reason once.
    pub fn deaf(&self, name: &str, type_name: &str, offered: Quality) -> Vec<String> {
        let mut reasons = Vec::new();
        for reader in self.readers.iter().filter(|reader| reader.topic == name) {
            let quality = reader.quality();
            let reason = if reader.type_name != type_name {
                format!("{name} is {type_name}, but somebody asks for {} there", reader.type_name)
            } else if reader.reliable && !offered.is_reliable() || reader.latched && !offered.is_latched() {
                format!("{name} is published as {}, but somebody asks for {quality}", offered.name())
            } else {
                continue;
            };
            if !reasons.contains(&reason) {
                reasons.push(reason);
            }
        }
        reasons
    }

    /// The topic of that name.
    pub fn topic(&self, name: &str) -> Option<&GraphTopic> {
        self.topics.iter().find(|topic| topic.name == name)
    }

    /// How many others listen to a topic.
    pub fn listeners(&self, name: &str) -> usize {
        self.readers.iter().filter(|reader| reader.topic == name).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn endpoint(topic: &str, type_name: &str, reliable: bool, latched: bool) -> Endpoint {
        Endpoint { topic: topic.into(), type_name: type_name.into(), reliable, latched }
    }

    #[test]
    fn a_topic_is_as_good_as_its_worst_publisher() {
        let writers = vec![endpoint("/a", "x/msg/X", true, true), endpoint("/a", "y/msg/Y", false, true)];
        let mut graph = Graph { writers, ..Graph::default() };
        graph.gather();
        let topic = graph.topic("/a").unwrap();
        assert_eq!((topic.writers, topic.reliable, topic.latched), (2, false, true));
        assert_eq!(topic.types, ["x/msg/X", "y/msg/Y"]);
        assert!(graph.topic("/b").is_none());
    }

    #[test]
    fn who_does_not_hear_whom_is_said_with_the_reason() {
        let graph = Graph {
            writers: vec![
                endpoint("/a", "x/msg/X", false, false),
                endpoint("/a", "x/msg/X", false, false),
                endpoint("/a", "x/msg/X", true, false),
                endpoint("/a", "y/msg/Y", true, true),
            ],
            readers: vec![endpoint("/a", "x/msg/X", true, true), endpoint("/b", "x/msg/X", true, true)],
            topics: Vec::new(),
        };
        let stream = Quality::Stream { depth: 1 };
        let unheard = graph.unheard("/a", "x/msg/X", stream);
        assert_eq!(unheard.len(), 2, "{unheard:?}");
        assert!(unheard[0].contains("publishes it as best effort and volatile"), "{unheard:?}");
        assert!(unheard[1].contains("publishes y/msg/Y"), "{unheard:?}");
        assert_eq!(graph.unheard("/a", "x/msg/X", Quality::Sensor).len(), 1, "another type alone");
        assert_eq!(graph.unheard("/a", "x/msg/X", Quality::Latched { depth: 1 }).len(), 3);
        let deaf = graph.deaf("/a", "x/msg/X", stream);
        assert!(deaf.len() == 1 && deaf[0].contains("asks for reliable and transient local"), "{deaf:?}");
        assert!(graph.deaf("/a", "x/msg/X", Quality::Latched { depth: 1 }).is_empty());
        assert_eq!(graph.deaf("/b", "y/msg/Y", stream).len(), 1);
    }
}
