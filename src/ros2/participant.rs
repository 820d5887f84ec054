//! A participant in a DDS domain, what it publishes and what it subscribes to.

use std::collections::HashMap;
use std::task::Waker;

use rustdds::bytes::Bytes;
use rustdds::dds::WriteError;
use rustdds::no_key::{DataWriter, SimpleDataReader};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, GUID, QosPolicies, RTPSEntity, Timestamp, Topic, TopicKind,
};

use crate::base::Result;
use crate::ros2::environment::Environment;
use crate::ros2::graph::Graph;
use crate::ros2::name::{dds_topic, dds_type};
use crate::ros2::qos::Quality;
use crate::ros2::raw::{ENCAPSULATION, LITTLE_ENDIAN, Raw};
use crate::ros2::ros2_error;
use crate::ros2::service::Origin;
use crate::ros2::vigil::Vigil;

/// See the module. Dropping it leaves the domain.
pub struct Participant {
    dds: DomainParticipant,
    publisher: rustdds::Publisher,
    subscriber: rustdds::Subscriber,
    vigil: Vigil,
}

impl Participant {
    /// Joins the domain of `environment`.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`] where no socket can be had.
    pub fn join(environment: &Environment) -> Result<Self> {
        let failed = |error: rustdds::dds::CreateError| ros2_error("joining the domain", error);
        let mut builder = DomainParticipantBuilder::new(environment.domain);
        if let Some(networks) = environment.networks() {
            builder = builder.with_only_networks(networks);
        }
        let (dds, vigil) = Vigil::of(|| builder.build()).map_err(failed)?;
        let none = QosPolicies::qos_none();
        Ok(Self {
            publisher: dds.create_publisher(&none).map_err(failed)?,
            subscriber: dds.create_subscriber(&none).map_err(failed)?,
            dds,
            vigil,
        })
    }

    /// Whether it still sends and receives; not after the process was stopped or the computer slept. Then another has to join.
    pub fn is_alive(&self) -> bool {
        self.vigil.all_run()
    }

    /// What is known of others now.
    pub fn graph(&self) -> Graph {
        Graph::of(&self.dds)
    }

    /// The participant's identity.
    pub fn guid(&self) -> [u8; 16] {
        self.dds.guid().to_bytes()
    }

    /// Publishes what tells which node the endpoints belong to.
    pub(super) fn publish_nodes(&self) -> Result<Publication> {
        let (name, policies) = ("ros_discovery_info", Quality::Latched { depth: 1 }.of_writer());
        let type_name = "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_".into();
        Ok(Publication { name: name.into(), writer: self.publish_raw(name, type_name, policies)? })
    }

    /// Publishes on the topic of that full name; `type_name` as in `sensor_msgs/msg/Image`.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`] where DDS refuses it.
    pub fn publish(&self, name: &str, type_name: &str, quality: Quality) -> Result<Publication> {
        let writer =
            self.publish_raw(&dds_topic(name), message_type(name, type_name)?, quality.of_writer())?;
        Ok(Publication { name: name.into(), writer })
    }

    /// Subscribes to the topic of that full name.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`] where DDS refuses it.
    pub fn subscribe(&self, name: &str, type_name: &str, quality: Quality) -> Result<Subscription> {
        self.subscribe_raw(&dds_topic(name), message_type(name, type_name)?, &quality.of_reader())
    }

    /// Publishes on a topic by its name and type in DDS.
    pub(super) fn publish_raw(
        &self,
        name: &str,
        type_name: String,
        policies: QosPolicies,
    ) -> Result<DataWriter<Bytes, Raw>> {
        let topic = self.topic(name, type_name, &policies)?;
        let writer = self.publisher.create_datawriter_no_key::<Bytes, Raw>(&topic, Some(policies));
        writer.map_err(|error| ros2_error(name, error))
    }

    /// Subscribes to a topic by its name and type in DDS.
    pub(super) fn subscribe_raw(
        &self,
        name: &str,
        type_name: String,
        policies: &QosPolicies,
    ) -> Result<Subscription> {
        let topic = self.topic(name, type_name, policies)?;
        let reader =
            self.subscriber.create_simple_datareader_no_key::<Vec<u8>, Raw>(&topic, Some(policies.clone()));
        let reader = reader.map_err(|error| ros2_error(name, error))?;
        Ok(Subscription { reader, last: HashMap::new() })
    }

    fn topic(&self, name: &str, type_name: String, policies: &QosPolicies) -> Result<Topic> {
        let topic = self.dds.create_topic(name.into(), type_name, policies, TopicKind::NoKey);
        topic.map_err(|error| ros2_error(name, error))
    }
}

/// DDS name of a message's type.
fn message_type(name: &str, type_name: &str) -> Result<String> {
    dds_type(type_name)
        .ok_or_else(|| ros2_error(name, format!("`{type_name}` is not a message type (package/msg/Name)")))
}

/// What is published on a topic.
pub struct Publication {
    name: String,
    writer: DataWriter<Bytes, Raw>,
}

impl Publication {
    /// Full name of the topic.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Identity of the writer.
    pub fn guid(&self) -> [u8; 16] {
        self.writer.guid().to_bytes()
    }

    /// Sends a message, its encapsulation in front; whether it was taken: not where a reliable reader has not answered for
    /// so long that no more are kept for it.
    ///
    /// # Errors
    /// [`crate::Error::Ros2`] for a message that is not little-endian CDR, and where DDS fails.
    pub fn send(&self, payload: impl Into<Bytes>) -> Result<bool> {
        let payload = payload.into();
        if payload.get(..2) != Some(&LITTLE_ENDIAN[..2]) || payload.len() < ENCAPSULATION {
            return Err(ros2_error(&self.name, "the message is not little-endian CDR"));
        }
        let body = payload.slice(ENCAPSULATION..);
        match self.writer.write(body, Some(Timestamp::now())) {
            Ok(()) => Ok(true),
            Err(WriteError::WouldBlock { .. }) => Ok(false),
            Err(error) => Err(ros2_error(&self.name, error)),
        }
    }

    /// Waits until every reliable reader has what was sent, or for so long.
    pub fn flush(&self, at_most: std::time::Duration) {
        // What a reader misses when this ends is its own affair.
        let _ = self.writer.wait_for_acknowledgments(at_most);
    }
}

/// What is received on a topic.
pub struct Subscription {
    reader: SimpleDataReader<Vec<u8>, Raw>,
    /// Number of the newest message by writer.
    last: HashMap<GUID, i64>,
}

/// What became of messages of a topic.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Taken {
    /// Lost on the way, as their numbers tell.
    pub lost: u64,
    /// Of an encoding that is not CDR.
    pub malformed: u64,
}

/// Most writers of a topic whose numbers are remembered.
const MAX_WRITERS: usize = 256;

impl Subscription {
    /// Identity of the reader.
    pub fn guid(&self) -> [u8; 16] {
        self.reader.guid().to_bytes()
    }

    /// Gives all messages that are there to `give`, and has `waker` woken at the next.
    pub(super) fn drain(&mut self, waker: &Waker, give: &mut dyn FnMut(Origin, Vec<u8>)) -> Taken {
        let mut taken = Taken::default();
        // Asked for before the last look, so that nothing comes between.
        self.reader.set_waker(Some(waker.clone()));
        self.reader.drain_read_notifications();
        loop {
            match self.reader.try_take_one() {
                Ok(Some(sample)) => {
                    let (writer, number) = (sample.writer_guid, i64::from(sample.sequence_number));
                    taken.lost += self.gap(writer, number);
                    give(Origin { writer: writer.to_bytes(), number }, sample.into_value());
                }
                Ok(None) => return taken,
                Err(_) => taken.malformed += 1,
            }
        }
    }

    /// How many messages of a writer are missing before this one.
    fn gap(&mut self, writer: GUID, number: i64) -> u64 {
        if self.last.len() >= MAX_WRITERS && !self.last.contains_key(&writer) {
            self.last.clear();
        }
        match self.last.insert(writer, number) {
            Some(last) => u64::try_from(number.saturating_sub(last).saturating_sub(1)).unwrap_or(0),
            None => 0,
        }
    }
}
