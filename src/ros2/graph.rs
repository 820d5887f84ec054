//! What others publish and listen to, as discovery has found it.

use rustdds::policy::{Durability, Reliability};

use crate::ros2::name::{topic_of_dds, type_of_dds};

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

/// A moment's view of the graph.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Graph {
    /// By name.
    pub topics: Vec<GraphTopic>,
    /// Full name of the topic of every reader of others.
    readers: Vec<String>,
}

impl Graph {
    pub(super) fn of(dds: &rustdds::DomainParticipant) -> Self {
        let mut graph = Self::default();
        for writer in dds.discovered_writers() {
            let data = &writer.publication_topic_data;
            let Some(name) = topic_of_dds(&data.topic_name) else { continue };
            let reliable = matches!(data.reliability, Some(Reliability::Reliable { .. }));
            let latched = !matches!(data.durability, None | Some(Durability::Volatile));
            graph.count(name, type_of_dds(&data.type_name), reliable, latched);
        }
        let readers = dds.discovered_readers();
        let names =
            readers.iter().filter_map(|reader| topic_of_dds(reader.subscription_topic_data.topic_name()));
        graph.readers = names.map(str::to_owned).collect();
        graph.topics.sort_by(|a, b| a.name.cmp(&b.name));
        graph
    }

    fn count(&mut self, name: &str, type_name: String, reliable: bool, latched: bool) {
        match self.topics.iter_mut().find(|topic| topic.name == name) {
            Some(topic) => {
                topic.writers += 1;
                topic.reliable &= reliable;
                topic.latched &= latched;
                if !topic.types.contains(&type_name) {
                    topic.types.push(type_name);
                }
            }
            None => self.topics.push(GraphTopic {
                name: name.into(),
                types: vec![type_name],
                writers: 1,
                reliable,
                latched,
            }),
        }
    }

    /// The topic of that name.
    pub fn topic(&self, name: &str) -> Option<&GraphTopic> {
        self.topics.iter().find(|topic| topic.name == name)
    }

    /// How many others listen to a topic.
    pub fn listeners(&self, name: &str) -> usize {
        self.readers.iter().filter(|reader| *reader == name).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_topic_is_as_good_as_its_worst_publisher() {
        let mut graph = Graph::default();
        graph.count("/a", "x/msg/X".into(), true, true);
        graph.count("/a", "y/msg/Y".into(), false, true);
        let topic = graph.topic("/a").unwrap();
        assert_eq!((topic.writers, topic.reliable, topic.latched), (2, false, true));
        assert_eq!(topic.types, ["x/msg/X", "y/msg/Y"]);
        assert!(graph.topic("/b").is_none());
    }
}
