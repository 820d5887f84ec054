//! Lidar messages that are known and not read, by the type's package.

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

/// Whose packets a type that is not read holds; `None` where it does not look like packets.
pub(super) fn packets_of(schema: &str) -> Option<&'static str> {
    let mut parts = schema.split('/');
    let package = parts.next()?;
    let name = parts.next_back()?.to_lowercase();
    let known = PACKETS.iter().find(|(known, _)| package == *known).map(|(_, sensor)| *sensor);
    let is_packets = WORDS.iter().any(|word| name.contains(word)) || name.ends_with("scan");
    match known {
        Some(sensor) => is_packets.then_some(sensor),
        None => WORDS.iter().any(|word| name.contains(word)).then_some("a sensor"),
    }
}
