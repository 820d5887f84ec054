//! What the first message of a cloud topic says of it: enough to choose between topics, and to tell a camera's own cloud.

use std::collections::BTreeSet;

use crate::input::log::cameras::find_depth;
use crate::input::log::topics::{Channel, Channels, Kind};
use crate::input::points::cloud;
use crate::message::lidar::PointCloud;
use crate::message::{bare_frame, foxglove, ros2};

/// Frames of maps: a cloud in one of these is put together from scans, and does not lie in its sensor's frame.
const MAP_FRAMES: [&str; 5] = ["map", "odom", "world", "camera_init", "earth"];

/// See the module.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Layout {
    frame_id: String,
    /// Names of fields.
    fields: Vec<String>,
}

impl Layout {
    /// Of a message; `None` where it is not a cloud, or cannot be read.
    pub(super) fn of(kind: Kind, payload: &[u8]) -> Option<Self> {
        match kind {
            Kind::RosPointCloud(wire) => {
                let message: ros2::PointCloud2 = wire.decode("sensor_msgs/PointCloud2", payload).ok()?;
                let fields = message.fields.into_iter().map(|field| field.name).collect();
                Some(Self { frame_id: bare_frame(message.header.frame_id), fields })
            }
            Kind::OldPointCloud(wire) => {
                let message: PointCloud = wire.decode("sensor_msgs/PointCloud", payload).ok()?;
                let channels = message.channels.into_iter().map(|channel| channel.name);
                let fields = ["x", "y", "z"].map(String::from).into_iter().chain(channels).collect();
                Some(Self { frame_id: bare_frame(message.header.frame_id), fields })
            }
            Kind::FoxglovePointCloud => {
                let message: foxglove::PointCloud =
                    foxglove::decode_protobuf("foxglove.PointCloud", payload).ok()?;
                let fields = message.fields.into_iter().map(|field| field.name).collect();
                Some(Self { frame_id: bare_frame(message.frame_id), fields })
            }
            _ => None,
        }
    }

    fn has(&self, names: &[&str]) -> bool {
        cloud::find_field(&self.fields, names).is_some()
    }

    fn is_placed(&self) -> bool {
        ["x", "y", "z"].iter().all(|name| self.has(&[name]))
    }

    /// Whether it looks like the cloud that a camera's driver makes of its depth images.
    pub(super) fn is_of_camera(&self) -> bool {
        let colored = self.has(&["rgb", "rgba"]) || self.has(&["r"]) && self.has(&["g"]) && self.has(&["b"]);
        !self.is_of_lidar() && (colored || self.frame_id.contains("optical"))
    }

    /// Whether it has what lidars give and cameras do not.
    pub(super) fn is_of_lidar(&self) -> bool {
        self.has(cloud::INTENSITY) || self.has(cloud::RING)
    }

    pub(super) fn frame_id(&self) -> &str {
        &self.frame_id
    }

    /// What it lacks, the gravest first: the least is the best.
    pub(super) fn lacks(&self) -> [bool; 6] {
        [
            !self.is_placed(),
            self.is_of_camera(),
            MAP_FRAMES.contains(&self.frame_id.as_str()),
            !self.has(cloud::INTENSITY),
            !self.has(cloud::TIME),
            !self.has(cloud::RING),
        ]
    }
}

impl Channels {
    /// The channels whose first message says what their topic is: clouds, where there are others or a camera beside them.
    pub(super) fn to_look_at(&self) -> BTreeSet<u32> {
        if self.of_kind(Kind::is_scan).count() < 2 && find_depth(self).is_none() {
            return BTreeSet::new();
        }
        let clouds =
            self.by_id.iter().filter(|(_, c)| c.kind.is_some_and(Kind::is_cloud) && c.messages != Some(0));
        clouds.map(|(id, _)| *id).collect()
    }

    /// Takes in the first message of a channel.
    pub(super) fn look_at(&mut self, id: u32, payload: &[u8]) {
        let Some(Channel { topic, kind: Some(kind), .. }) = self.by_id.get(&id) else { return };
        if let Some(layout) = Layout::of(*kind, payload) {
            self.layouts.insert(topic.clone(), layout);
        }
    }

    /// What the first message of a topic said of it, where it was looked at.
    pub(super) fn layout(&self, topic: &str) -> Option<&Layout> {
        self.layouts.get(topic)
    }
}
