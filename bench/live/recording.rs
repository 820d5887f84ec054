//! A recording in memory whose messages can be sent with other stamps.

use std::path::Path;

use limpid::input::playback::{Playback, Played, PlayedTopic, Purpose};
use limpid::message::ros2::{Header, TFMessage, Time, decode_cdr, encode_cdr};
use limpid::ros2::{Participant, Publication, Quality};
use limpid::{Config, Error, Result};

/// See the module.
pub(crate) struct Recording {
    pub(crate) topics: Vec<PlayedTopic>,
    pub(crate) messages: Vec<Played>,
    /// The topic of depth images.
    pub(crate) depth: usize,
    /// From the first to the last message and on to the next round, nanoseconds.
    pub(crate) span_ns: u64,
    /// Depth images.
    pub(crate) frames: u64,
}

impl Recording {
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let mut playback = Playback::open(path, &Config::default())?;
        let mut messages = Vec::new();
        while let Some(played) = playback.next_message()? {
            messages.push(played);
        }
        let topics = playback.topics().to_vec();
        let is_depth =
            |topic: &PlayedTopic| topic.type_name == "sensor_msgs/msg/Image" && topic.name.contains("depth");
        let depth = topics.iter().position(is_depth);
        let depth = depth.ok_or(Error::Empty { reason: "it has no depth images".into() })?;
        let times = messages.iter().filter(|message| message.topic == depth).map(|message| message.at_ns);
        let times: Vec<u64> = times.collect();
        let frames = times.len() as u64;
        let length_ns = times.last().unwrap_or(&0) - times.first().unwrap_or(&0);
        let span_ns = length_ns + length_ns / frames.saturating_sub(1).max(1);
        Ok(Self { topics, messages, depth, span_ns, frames })
    }

    /// Publishes all topics, sensors' data reliably.
    pub(crate) fn publish(&self, participant: &Participant) -> Result<Vec<Publication>> {
        let publish = |topic: &PlayedTopic| {
            let quality = match topic.purpose {
                Purpose::Fixed => Quality::Latched { depth: 100 },
                Purpose::Sensor | Purpose::Stream => Quality::Stream { depth: 100 },
            };
            participant.publish(&topic.name, &topic.type_name, quality)
        };
        self.topics.iter().map(publish).collect()
    }

    /// A message with its stamps later by so much.
    pub(crate) fn later(&self, message: &Played, by_ns: u64) -> Result<Vec<u8>> {
        let later = |time: Time| time.stamp_ns().map(|stamp_ns| Time::from_stamp_ns(stamp_ns + by_ns));
        let type_name = self.topics[message.topic].type_name.as_str();
        if type_name == "tf2_msgs/msg/TFMessage" {
            let mut transforms: TFMessage = decode_cdr(type_name, &message.payload)?;
            for transform in &mut transforms.transforms {
                transform.header.stamp = later(transform.header.stamp)?;
            }
            return encode_cdr(type_name, &transforms);
        }
        // All others begin with a header, which begins with its stamp.
        let mut payload = message.payload.clone();
        let stamp = later(decode_cdr::<Header>(type_name, &payload)?.stamp)?;
        payload[4..12].copy_from_slice(&encode_cdr("stamp", &stamp)?[4..12]);
        Ok(payload)
    }
}
