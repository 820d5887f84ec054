//! What the node publishes: topics by name, made when they are first sent, and not computed while nobody listens.

use std::collections::HashMap;
use std::time::Duration;

use serde::Serialize;

use crate::base::Result;
use crate::message::RosMessage;
use crate::message::ros2::encode_cdr;
use crate::ros2::{Graph, Naming, Participant, Publication, Quality};

/// See the module.
pub(super) struct Outputs<'a> {
    participant: &'a Participant,
    naming: &'a Naming,
    /// By the name that is asked for, such as `~/costmap`.
    publications: HashMap<String, Publication>,
    graph: Graph,
    /// Messages that a reliable reader held up.
    pub(super) held_up: u64,
}

impl<'a> Outputs<'a> {
    pub(super) fn new(participant: &'a Participant, naming: &'a Naming) -> Self {
        Self { participant, naming, publications: HashMap::new(), graph: Graph::default(), held_up: 0 }
    }

    /// Takes what is known of others now.
    pub(super) fn see(&mut self, graph: Graph) {
        self.graph = graph;
    }

    /// How many listen to a topic.
    pub(super) fn listeners(&self, name: &str) -> usize {
        self.publications.get(name).map_or(0, |publication| self.graph.listeners(publication.name()))
    }

    /// Identities of the writers.
    pub(super) fn writers(&self) -> Vec<[u8; 16]> {
        let mut writers: Vec<_> = self.publications.values().map(Publication::guid).collect();
        writers.sort_unstable();
        writers
    }

    /// Has a topic so that others find it.
    pub(super) fn offer(&mut self, name: &str, type_name: &str, quality: Quality) -> Result<()> {
        if !self.publications.contains_key(name) {
            let publication = self.participant.publish(&self.naming.resolve(name)?, type_name, quality)?;
            self.publications.insert(name.into(), publication);
        }
        Ok(())
    }

    /// Sends a message.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`]; [`crate::Error::Decode`] for sequences too long for CDR.
    pub(super) fn send<M: RosMessage + Serialize>(
        &mut self,
        name: &str,
        quality: Quality,
        message: &M,
    ) -> Result<()> {
        self.offer(name, M::TYPE, quality)?;
        let payload = encode_cdr(M::TYPE, message)?;
        if let Some(publication) = self.publications.get(name)
            && !publication.send(payload)?
        {
            self.held_up += 1;
        }
        Ok(())
    }

    /// Waits until every reliable reader has what was sent of a topic, or for so long.
    pub(super) fn flush(&self, name: &str, at_most: Duration) {
        if let Some(publication) = self.publications.get(name) {
            publication.flush(at_most);
        }
    }
}
