//! A client of services, over DDS as another RMW would be one ("enhanced" mapping), and what it asks of a node.

use std::time::{Duration, Instant};

use limpid::message::ros2::{decode_cdr, encode_cdr};
use limpid::ros2::Environment;
use rustdds::bytes::Bytes;
use rustdds::no_key::{
    DataWriter, Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter, SimpleDataReader,
};
use rustdds::policy::{Durability, History, Reliability};
use rustdds::{
    DomainParticipant, DomainParticipantBuilder, QosPolicies, QosPolicyBuilder, RepresentationIdentifier,
    TopicKind, WriteOptions,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::peer::PATIENCE;

/// Bodies of messages.
struct Bodies;

#[derive(Debug)]
struct Never;

impl std::fmt::Display for Never {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("never")
    }
}

impl std::error::Error for Never {}

#[derive(Clone)]
struct AsIs;

impl Decode<'_, Vec<u8>> for AsIs {
    type Error = Never;

    fn decode_bytes(self, body: &[u8], _: RepresentationIdentifier) -> Result<Vec<u8>, Never> {
        Ok(body.to_vec())
    }
}

impl DeserializerAdapter<Vec<u8>> for Bodies {
    type Error = Never;
    type Decoded = Vec<u8>;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        &[RepresentationIdentifier::CDR_LE]
    }

    fn transform_decoded(decoded: Vec<u8>) -> Vec<u8> {
        decoded
    }
}

impl DefaultDecoder<Vec<u8>> for Bodies {
    type Decoder = AsIs;
    const DECODER: AsIs = AsIs;
}

impl SerializerAdapter<Bytes> for Bodies {
    type Error = Never;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(body: &Bytes) -> Result<Bytes, Never> {
        Ok(body.clone())
    }
}

/// A client of one service.
pub(super) struct Client {
    requests: DataWriter<Bytes, Bodies>,
    replies: SimpleDataReader<Vec<u8>, Bodies>,
    _participant: DomainParticipant,
}

fn qualities() -> QosPolicies {
    QosPolicyBuilder::new()
        .reliability(Reliability::Reliable { max_blocking_time: rustdds::Duration::from_secs(1) })
        .durability(Durability::Volatile)
        .history(History::KeepLast { depth: 10 })
        .build()
}

impl Client {
    /// Of the service of that full name; `of` as in `std_srvs/Trigger`. Returns when the service is found.
    pub(super) fn new(environment: &Environment, name: &str, of: &str) -> Self {
        let loopback = [std::net::IpAddr::from([127, 0, 0, 1])];
        let builder = DomainParticipantBuilder::new(environment.domain).with_only_networks(loopback);
        let participant = builder.build().unwrap();
        let (package, kind) = of.split_once('/').unwrap();
        let topic = |name: String, half: &str| {
            let type_name = format!("{package}::srv::dds_::{kind}_{half}_");
            participant.create_topic(name, type_name, &qualities(), TopicKind::NoKey).unwrap()
        };
        let (publisher, subscriber) = (
            participant.create_publisher(&qualities()).unwrap(),
            participant.create_subscriber(&qualities()).unwrap(),
        );
        let requests = topic(format!("rq{name}Request"), "Request");
        let replies = topic(format!("rr{name}Reply"), "Response");
        let client = Self {
            requests: publisher.create_datawriter_no_key(&requests, None).unwrap(),
            replies: subscriber.create_simple_datareader_no_key(&replies, None).unwrap(),
            _participant: participant,
        };
        let until = Instant::now() + PATIENCE;
        let found = || {
            let (readers, writers) =
                (client._participant.discovered_readers(), client._participant.discovered_writers());
            readers
                .iter()
                .any(|of| of.subscription_topic_data.topic_name().starts_with(&format!("rq{name}R")))
                && writers
                    .iter()
                    .any(|of| of.publication_topic_data.topic_name.starts_with(&format!("rr{name}R")))
        };
        while !found() {
            assert!(Instant::now() < until, "nobody serves {name}");
            std::thread::sleep(Duration::from_millis(20));
        }
        // The service has to find the client too.
        std::thread::sleep(Duration::from_millis(300));
        client
    }

    /// Sends a request; its number.
    pub(super) fn ask<T: Serialize>(&self, request: &T) -> rustdds::SampleIdentity {
        let payload = encode_cdr("request", request).unwrap();
        let body = Bytes::from(payload).slice(4..);
        self.requests.write_with_options(body, WriteOptions::from(None)).unwrap()
    }

    /// The reply to a request, where one comes by then.
    pub(super) fn reply<T: DeserializeOwned>(
        &self,
        to: rustdds::SampleIdentity,
        until: Instant,
    ) -> Option<T> {
        while Instant::now() < until {
            self.replies.drain_read_notifications();
            match self.replies.try_take_one().unwrap() {
                Some(sample) if sample.write_options.related_sample_identity() == Some(to) => {
                    let payload = [&[0, 1, 0, 0], &sample.sample[..]].concat();
                    return Some(decode_cdr("reply", &payload).unwrap());
                }
                Some(_) => {}
                None => std::thread::sleep(Duration::from_millis(5)),
            }
        }
        None
    }

    #[track_caller]
    pub(super) fn call<T: Serialize, U: DeserializeOwned>(&self, request: &T) -> U {
        let asked = self.ask(request);
        self.reply(asked, Instant::now() + PATIENCE).expect("a reply comes")
    }
}
