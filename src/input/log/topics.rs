//! Which channels of a recording are what: by configuration, else by message type and name.

use std::collections::BTreeMap;
use std::path::Path;

use serde::de::DeserializeOwned;

use crate::base::{Error, Result};
use crate::config::Config;
use crate::input::log::cameras::{find_color, find_depth, sibling_info, unread};
use crate::input::log::layout::Layout;
use crate::input::log::look::Look;
use crate::input::log::records::Record;
use crate::message::{ros1, ros2};

/// How ROS messages are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Wire {
    Cdr,
    Ros1,
}

impl Wire {
    /// The message in a payload of type `what`.
    pub(super) fn decode<T: DeserializeOwned>(self, what: &str, payload: &[u8]) -> Result<T> {
        match self {
            Self::Cdr => ros2::decode_cdr(what, payload),
            Self::Ros1 => ros1::decode(what, payload),
        }
    }
}

/// The message types that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    RosImage(Wire),
    RosCompressedImage(Wire),
    RosCameraInfo(Wire),
    RosTransforms(Wire),
    RosOdometry(Wire),
    RosPoseStamped(Wire),
    /// A transform without frames and stamp, and a number: both only of the RealSense SDK.
    RosTransform(Wire),
    RosFloat(Wire),
    FoxgloveRawImage,
    FoxgloveCompressedImage,
    FoxgloveCalibration,
    FoxgloveTransform,
    FoxgloveTransforms,
    RosPointCloud(Wire),
    /// `sensor_msgs/PointCloud`, before `PointCloud2`.
    OldPointCloud(Wire),
    FoxglovePointCloud,
    FoxgloveLaserScan,
    VelodyneScan(Wire),
    LivoxCustom(Wire),
    LaserScan(Wire),
    MultiEchoLaserScan(Wire),
}

impl Kind {
    fn of(message_encoding: &str, schema: &str) -> Option<Self> {
        match message_encoding {
            "cdr" => Self::of_ros(Wire::Cdr, &schema.replace("/msg/", "/")),
            "ros1" => Self::of_ros(Wire::Ros1, schema),
            "protobuf" => Some(match schema {
                "foxglove.RawImage" => Self::FoxgloveRawImage,
                "foxglove.CompressedImage" => Self::FoxgloveCompressedImage,
                "foxglove.CameraCalibration" => Self::FoxgloveCalibration,
                "foxglove.FrameTransform" => Self::FoxgloveTransform,
                "foxglove.FrameTransforms" => Self::FoxgloveTransforms,
                "foxglove.PointCloud" => Self::FoxglovePointCloud,
                "foxglove.LaserScan" => Self::FoxgloveLaserScan,
                _ => return None,
            }),
            _ => None,
        }
    }

    fn of_ros(wire: Wire, schema: &str) -> Option<Self> {
        Some(match schema {
            "sensor_msgs/Image" => Self::RosImage(wire),
            "sensor_msgs/CompressedImage" => Self::RosCompressedImage(wire),
            "sensor_msgs/CameraInfo" => Self::RosCameraInfo(wire),
            "tf2_msgs/TFMessage" | "tf/tfMessage" => Self::RosTransforms(wire),
            "nav_msgs/Odometry" => Self::RosOdometry(wire),
            "geometry_msgs/PoseStamped" => Self::RosPoseStamped(wire),
            "geometry_msgs/Transform" => Self::RosTransform(wire),
            "std_msgs/Float32" => Self::RosFloat(wire),
            "sensor_msgs/PointCloud2" => Self::RosPointCloud(wire),
            "sensor_msgs/PointCloud" => Self::OldPointCloud(wire),
            "velodyne_msgs/VelodyneScan" => Self::VelodyneScan(wire),
            "livox_ros_driver2/CustomMsg" | "livox_ros_driver/CustomMsg" | "livox_interfaces/CustomMsg" => {
                Self::LivoxCustom(wire)
            }
            "sensor_msgs/LaserScan" => Self::LaserScan(wire),
            "sensor_msgs/MultiEchoLaserScan" => Self::MultiEchoLaserScan(wire),
            _ => return None,
        })
    }

    pub(super) fn is_raw_image(self) -> bool {
        matches!(self, Self::RosImage(_) | Self::FoxgloveRawImage)
    }

    pub(super) fn is_image(self) -> bool {
        self.is_raw_image() || matches!(self, Self::RosCompressedImage(_) | Self::FoxgloveCompressedImage)
    }

    pub(super) fn is_calibration(self) -> bool {
        matches!(self, Self::RosCameraInfo(_) | Self::FoxgloveCalibration)
    }

    pub(super) fn is_scan(self) -> bool {
        let is_packed = matches!(self, Self::VelodyneScan(_) | Self::LivoxCustom(_));
        is_packed || self.is_cloud() || self.is_flat_scan()
    }

    pub(super) fn is_cloud(self) -> bool {
        matches!(self, Self::RosPointCloud(_) | Self::OldPointCloud(_) | Self::FoxglovePointCloud)
    }

    pub(super) fn is_flat_scan(self) -> bool {
        matches!(self, Self::LaserScan(_) | Self::MultiEchoLaserScan(_) | Self::FoxgloveLaserScan)
    }

    pub(super) fn is_transforms(self) -> bool {
        matches!(self, Self::RosTransforms(_) | Self::FoxgloveTransform | Self::FoxgloveTransforms)
    }
}

/// A channel, its message type where it is one that is read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Channel {
    pub(super) topic: String,
    pub(super) kind: Option<Kind>,
    pub(super) schema: String,
    /// How its messages are written, as MCAP names that.
    pub(super) message_encoding: String,
    /// Schema and message encoding, for messages to the user.
    pub(super) type_name: String,
    /// Where the summary says how many.
    pub(super) messages: Option<u64>,
    /// What its first message shows, where that was read.
    pub(super) look: Option<Look>,
}

impl Channel {
    fn new(topic: String, message_encoding: &str, schema: &str) -> Self {
        let type_name = format!("{schema} ({message_encoding})");
        let kind = Kind::of(message_encoding, schema);
        Self {
            topic,
            kind,
            schema: schema.into(),
            message_encoding: message_encoding.into(),
            type_name,
            messages: None,
            look: None,
        }
    }
}

/// The channels of a recording.
#[derive(Debug, Clone, Default)]
pub(super) struct Channels {
    pub(super) by_id: BTreeMap<u32, Channel>,
    /// Of clouds, by topic, where it takes these to choose.
    pub(super) layouts: BTreeMap<String, Layout>,
    /// Log times of the first and the last message where the summary says so, nanoseconds.
    span_ns: Option<[u64; 2]>,
}

impl Channels {
    /// Takes what a record says about channels.
    pub(super) fn learn(&mut self, record: Record) {
        match record {
            Record::Topic { id, topic, type_name, message_encoding } => {
                let channel = || Channel::new(topic, &message_encoding, &type_name);
                self.by_id.entry(id).or_insert_with(channel);
            }
            Record::Statistics { message_counts, span_ns } => {
                self.span_ns = span_ns;
                for channel in self.by_id.values_mut() {
                    channel.messages = Some(0);
                }
                for (id, count) in message_counts {
                    if let Some(channel) = self.by_id.get_mut(&id) {
                        channel.messages = Some(count);
                    }
                }
            }
            // Files have these; what they say comes as topics.
            Record::Schema { .. } | Record::Channel { .. } | Record::Message { .. } => {}
        }
    }

    pub(super) fn get(&self, id: u32) -> Option<&Channel> {
        self.by_id.get(&id)
    }

    /// All channels with their numbers.
    pub(super) fn all(&self) -> impl Iterator<Item = (u32, &Channel)> {
        self.by_id.iter().map(|(&id, channel)| (id, channel))
    }

    /// Whether the summary says how many messages there are.
    pub(super) fn is_counted(&self) -> bool {
        self.by_id.values().any(|channel| channel.messages.is_some())
    }

    pub(super) fn span_ns(&self) -> Option<[u64; 2]> {
        self.span_ns
    }

    pub(super) fn is_empty(&self) -> bool {
        self.by_id.is_empty()
    }

    /// Whether there is such a topic.
    pub(super) fn has(&self, topic: &str) -> bool {
        self.by_id.values().any(|channel| channel.topic == topic)
    }

    /// These without some topics.
    pub(super) fn without(&self, topics: &[&str]) -> Self {
        let mut rest = self.clone();
        rest.by_id.retain(|_, channel| !topics.contains(&channel.topic.as_str()));
        rest
    }

    /// How many messages the summary says a topic has.
    pub(super) fn messages(&self, topic: &str) -> Option<u64> {
        self.by_id.values().filter(|channel| channel.topic == topic).map(|channel| channel.messages).sum()
    }

    /// Channels of a kind, those known to be empty left out.
    pub(super) fn of_kind(&self, is: impl Fn(Kind) -> bool) -> impl Iterator<Item = &Channel> {
        self.by_id.values().filter(move |c| c.kind.is_some_and(&is) && c.messages != Some(0))
    }

    /// As [`Self::of_kind`], by number.
    pub(super) fn of_kind_by_id(&self, is: impl Fn(Kind) -> bool) -> impl Iterator<Item = (u32, Kind)> {
        let of = move |(&id, channel): (&u32, &Channel)| Some((id, channel.kind.filter(|&kind| is(kind))?));
        self.by_id.iter().filter(|(_, channel)| channel.messages != Some(0)).filter_map(of)
    }

    /// Keeps what a channel's first message shows.
    pub(super) fn show(&mut self, id: u32, look: Look) {
        if let Some(channel) = self.by_id.get_mut(&id) {
            channel.look = Some(look);
        }
    }

    pub(super) fn has_transforms(&self) -> bool {
        self.of_kind(|kind| kind.is_transforms()).next().is_some()
    }

    /// The configured topic, if it is there and of the right kind; `None` where none is configured.
    pub(super) fn configured(
        &self,
        path: &Path,
        key: &str,
        topic: &str,
        is: impl Fn(Kind) -> bool,
    ) -> Result<Option<String>> {
        if topic.is_empty() {
            return Ok(None);
        }
        match self.by_id.values().find(|channel| channel.topic == topic) {
            Some(channel) if channel.kind.is_some_and(&is) => Ok(Some(topic.into())),
            Some(channel) => Err(Error::Config {
                key: key.into(),
                reason: format!("`{topic}` holds {}, which is not read here", channel.type_name),
            }),
            None => {
                let near = self.near(topic, &is);
                let reason = format!("{} has no topic `{topic}`; {near}", path.display());
                Err(Error::Config { key: key.into(), reason })
            }
        }
    }

    /// The topics of a kind nearest to a name.
    fn near(&self, topic: &str, is: &impl Fn(Kind) -> bool) -> String {
        let mut names: Vec<&str> = self.of_kind(is).map(|channel| channel.topic.as_str()).collect();
        if names.is_empty() {
            return "it has none of the right type".into();
        }
        names.sort_by(|a, b| {
            strsim::jaro_winkler(topic, b).total_cmp(&strsim::jaro_winkler(topic, a)).then(a.cmp(b))
        });
        names.truncate(3);
        format!("the nearest of the right type: {}", names.join(", "))
    }

    fn listing(&self) -> String {
        let all: Vec<String> =
            self.by_id.values().take(40).map(|c| format!("{} {}", c.topic, c.type_name)).collect();
        if all.is_empty() { "it has no topics".into() } else { format!("its topics are: {}", all.join(", ")) }
    }
}

/// The topics that are read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Topics {
    pub(super) depth: String,
    pub(super) depth_info: Option<String>,
    pub(super) color: Option<String>,
    pub(super) color_info: Option<String>,
    pub(super) confidence: Option<String>,
    pub(super) odometry: Option<String>,
    /// What else there is of cameras and is not read.
    pub(super) unread: Vec<String>,
}

impl Topics {
    /// # Errors
    /// [`Error::Config`] for a configured topic that is absent or of another type; [`Error::Format`]
    /// where no depth or no calibration topic is found.
    pub(super) fn choose(channels: &Channels, config: &Config, path: &Path) -> Result<Self> {
        let image = |key, topic: &str| channels.configured(path, key, topic, Kind::is_image);
        let info = |key, topic: &str| channels.configured(path, key, topic, Kind::is_calibration);
        let depth = image("depth_topic", &config.depth_topic)?
            .or_else(|| find_depth(channels))
            .ok_or_else(|| missing(path, "depth image", "depth_topic", channels))?;
        let color = image("color_topic", &config.color_topic)?.or_else(|| find_color(channels, &depth));
        let depth_info =
            info("depth_info_topic", &config.depth_info_topic)?.or_else(|| sibling_info(channels, &depth));
        let is_stated = config.camera_matrix != [0.0; 9];
        if depth_info.is_none() && !is_stated && channels.of_kind(Kind::is_calibration).next().is_none() {
            return Err(missing(path, "calibration", "depth_info_topic` or `camera_matrix", channels));
        }
        let color_info = info("color_info_topic", &config.color_info_topic)?
            .or_else(|| color.as_ref().and_then(|color| sibling_info(channels, color)));
        Ok(Self {
            unread: unread(channels, &depth, color.as_deref(), config),
            depth,
            depth_info,
            color,
            color_info,
            confidence: image("confidence_topic", &config.confidence_topic)?,
            odometry: channels.configured(path, "odometry_topic", &config.odometry_topic, |kind| {
                matches!(kind, Kind::RosOdometry(_))
            })?,
        })
    }

    /// One line for the report.
    pub(super) fn note(&self) -> String {
        let or = |topic: &Option<String>, other: &str| topic.clone().unwrap_or_else(|| other.into());
        format!(
            "topics: depth {} with calibration {}, colour {} with calibration {}, confidence {}, poses {}",
            self.depth,
            or(&self.depth_info, "by frame"),
            or(&self.color, "none"),
            if self.color.is_some() { or(&self.color_info, "by frame") } else { "none".into() },
            or(&self.confidence, "none"),
            or(&self.odometry, "from tf"),
        )
    }
}

pub(super) fn missing(path: &Path, what: &str, key: &str, channels: &Channels) -> Error {
    let reason = format!(
        "holds no {what} that is recognised by type and name; set `{key}` if there is one ({})",
        channels.listing()
    );
    Error::Format { path: path.into(), reason }
}
