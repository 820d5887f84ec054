//! What the node publishes: topics by name, made when they are first sent, and not computed while nobody listens.

use std::collections::HashMap;
use std::time::Duration;

use serde::Serialize;

use crate::base::{Error, Result};
use crate::message::RosMessage;
use crate::message::ros2::encode_cdr;
use crate::output::topics::TopicSink;
use crate::ros2::{Bytes, Graph, Naming, Participant, Publication, Quality};

/// Topics of the list that are told otherwise live: as a map with a margin and updates of it, and again when data stop.
const TOLD_OTHERWISE: [&str; 2] = ["costmap", "costmap_raw"];

/// What comes of single observations and maps. Volatile: who comes late must not take what is old for new. A reliable writer
/// serves readers of both kinds.
pub(super) const PASSING: Quality = Quality::Stream { depth: 2 };

/// A topic that is published.
struct Offer {
    publication: Publication,
    type_name: &'static str,
    quality: Quality,
    /// Whether it is one of the list, which changes with the sensors.
    listed: bool,
}

/// See the module.
pub(super) struct Outputs<'a> {
    participant: &'a Participant,
    naming: &'a Naming,
    /// By the name that is asked for, such as `~/costmap`.
    offers: HashMap<String, Offer>,
    graph: Graph,
    /// How often a reader that did not answer had a topic published anew.
    pub(super) held_up: u64,
}

impl<'a> Outputs<'a> {
    pub(super) fn new(participant: &'a Participant, naming: &'a Naming) -> Self {
        Self { participant, naming, offers: HashMap::new(), graph: Graph::default(), held_up: 0 }
    }

    /// Takes what is known of others now.
    pub(super) fn see(&mut self, graph: Graph) {
        self.graph = graph;
    }

    /// How many listen to a topic.
    pub(super) fn listeners(&self, name: &str) -> usize {
        self.offers.get(name).map_or(0, |offer| self.graph.listeners(offer.publication.name()))
    }

    /// Full name of a topic that is offered.
    pub(super) fn full_name(&self, name: &str) -> String {
        self.offers.get(name).map_or(name, |offer| offer.publication.name()).to_owned()
    }

    /// Why some of those who listen do not hear anything, and which topics others publish too.
    pub(super) fn unheard(&self) -> Vec<String> {
        let mut said = Vec::new();
        for (name, Offer { publication, type_name, quality, .. }) in &self.offers {
            said.extend(self.graph.deaf(publication.name(), type_name, *quality));
            if name.starts_with('~') && self.graph.topic(publication.name()).is_some() {
                said.push(format!(
                    "somebody else publishes {} too: is there another node of this name?",
                    publication.name()
                ));
            }
        }
        said.sort_unstable();
        said
    }

    /// Identities of the writers.
    pub(super) fn writers(&self) -> Vec<[u8; 16]> {
        let mut writers: Vec<_> = self.offers.values().map(|offer| offer.publication.guid()).collect();
        writers.sort_unstable();
        writers
    }

    /// Has a topic so that others find it.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn offer(&mut self, name: &str, type_name: &'static str, quality: Quality) -> Result<()> {
        self.open(name, type_name, quality, false)
    }

    fn open(&mut self, name: &str, type_name: &'static str, quality: Quality, listed: bool) -> Result<()> {
        if !self.offers.contains_key(name) {
            let publication = self.participant.publish(&self.naming.resolve(name)?, type_name, quality)?;
            self.offers.insert(name.into(), Offer { publication, type_name, quality, listed });
        }
        Ok(())
    }

    /// Has the topics of the list, those alone.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`].
    pub(super) fn offer_list(&mut self, topics: &[(String, &'static str)]) -> Result<()> {
        let listed = topics.iter().filter(|(name, _)| !TOLD_OTHERWISE.contains(&name.as_str()));
        let listed: Vec<_> = listed.map(|(name, kind)| (own(name), *kind)).collect();
        self.offers.retain(|name, offer| !offer.listed || listed.iter().any(|(listed, _)| listed == name));
        listed.iter().try_for_each(|(name, kind)| self.open(name, kind, PASSING, true))
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
        let payload = Bytes::from(encode_cdr(M::TYPE, message)?);
        match self.offers.get(name) {
            Some(offer) if !offer.publication.send(payload.clone())? => self.send_anew(name, payload),
            _ => Ok(()),
        }
    }

    /// A reader that does not answer has filled what a writer keeps, and would hold up all others: a new writer takes its
    /// place, which that reader has to find again.
    fn send_anew(&mut self, name: &str, payload: Bytes) -> Result<()> {
        self.held_up += 1;
        let Some(before) = self.offers.remove(name) else { return Ok(()) };
        let Offer { publication, type_name, quality, listed } = before;
        drop(publication);
        self.open(name, type_name, quality, listed)?;
        if let Some(offer) = self.offers.get(name) {
            offer.publication.send(payload)?;
        }
        Ok(())
    }

    /// Waits until every reliable reader has what was sent of a topic, or for so long.
    pub(super) fn flush(&self, name: &str, at_most: Duration) {
        if let Some(offer) = self.offers.get(name) {
            offer.publication.flush(at_most);
        }
    }
}

/// A name of the list under the node's own.
fn own(topic: &str) -> String {
    format!("~/{topic}")
}

impl TopicSink for Outputs<'_> {
    fn wants(&self, topic: &str) -> bool {
        !TOLD_OTHERWISE.contains(&topic) && self.listeners(&own(topic)) > 0
    }

    fn put<M: RosMessage>(&mut self, topic: &str, _: u64, message: &M) -> Result<()> {
        self.send(&own(topic), PASSING, message)
    }

    fn error(&self, reason: String) -> Error {
        Error::Ros2 { what: "a result".into(), reason }
    }
}
