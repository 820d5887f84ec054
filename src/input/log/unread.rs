//! Lidar messages that are known and not read, by the type's package.

use std::path::Path;

use crate::base::Error;
use crate::input::log::topics::{Channels, missing};

/// Packages of drivers' packet messages, and whose sensors they are for.
const PACKETS: [(&str, &str); 13] = [
    ("ouster_ros", "an Ouster sensor"),
    ("ouster_sensor_msgs", "an Ouster sensor"),
    ("ouster_msgs", "an Ouster sensor"),
    ("pandar_msgs", "a Hesai sensor"),
    ("hesai_ros_driver", "a Hesai sensor"),
    ("hesai_lidar", "a Hesai sensor"),
    ("nebula_msgs", "a sensor of the Nebula driver"),
    ("rslidar_msg", "a RoboSense sensor"),
    ("rslidar_msgs", "a RoboSense sensor"),
    ("seyond", "a Seyond sensor"),
    ("innovusion", "a Seyond sensor"),
    ("lslidar_msgs", "a Leishen sensor"),
    ("velodyne_msgs", "a Velodyne sensor"),
];

/// Words in the names of types that hold packets of some sensor.
const WORDS: [&str; 3] = ["packet", "udpframe", "scanraw"];

/// Words in the names of packages whose packets are no lidar's.
const OTHERS: [&str; 6] = ["image", "audio", "video", "ffmpeg", "can_", "radio"];

/// Whose packets a type that is not read holds; `None` where it does not look like packets.
pub(super) fn packets_of(schema: &str) -> Option<&'static str> {
    let mut parts = schema.split('/');
    let package = parts.next()?;
    let name = parts.next_back()?.to_lowercase();
    let known = PACKETS.iter().find(|(known, _)| package == *known).map(|(_, sensor)| *sensor);
    let is_packets = WORDS.iter().any(|word| name.contains(word)) || name.ends_with("scan");
    let is_other = OTHERS.iter().any(|word| package.contains(word));
    match known {
        Some(sensor) => is_packets.then_some(sensor),
        None => (is_packets && !is_other && !name.ends_with("scan")).then_some("a sensor"),
    }
}

impl Channels {
    /// Topics with packets of lidars that are not decoded, in words.
    pub(super) fn unread_packets(&self) -> Vec<String> {
        let unread = self.by_id.values().filter(|c| c.kind.is_none() && c.messages != Some(0));
        let words = unread.filter_map(|channel| {
            let sensor = packets_of(&channel.schema)?;
            Some(format!("{} ({}: packets of {sensor})", channel.topic, channel.schema))
        });
        words.collect()
    }
}

/// Why a log has no scans.
pub(super) fn missing_scans(path: &Path, key: &str, channels: &Channels) -> Error {
    let unread = channels.unread_packets();
    if unread.is_empty() {
        return missing(path, "point cloud, laser scan or Velodyne packets", key, channels);
    }
    let reason = format!(
        "holds {}, which are not decoded, and no scans: record the point clouds of the sensor's driver (sensor_msgs/PointCloud2) beside them or in their place",
        unread.join(", ")
    );
    Error::Format { path: path.into(), reason }
}
