//! ROS messages of lidars other than clouds of points: flat scans, and the Livox driver's own clouds.

use serde::{Deserialize, Serialize};

use crate::message::ros2::Header;

/// `sensor_msgs/msg/LaserScan`: ranges in one plane.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct LaserScan {
    /// Time of the first ray, and frame: rays lie in its plane z = 0.
    pub header: Header,
    /// Direction of the first ray, radians about z from x.
    pub angle_min: f32,
    /// Direction of the last ray.
    pub angle_max: f32,
    /// From one ray to the next.
    pub angle_increment: f32,
    /// From one ray to the next, seconds.
    pub time_increment: f32,
    /// From one scan to the next, seconds.
    pub scan_time: f32,
    /// Least range that is valid, metres.
    pub range_min: f32,
    /// Largest.
    pub range_max: f32,
    /// Metres.
    pub ranges: Vec<f32>,
    /// In the sensor's own unit; empty where it gives none.
    pub intensities: Vec<f32>,
}

/// `sensor_msgs/msg/LaserEcho`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct LaserEcho {
    /// Ranges, or intensities, of one ray, the nearest first.
    pub echoes: Vec<f32>,
}

/// `sensor_msgs/msg/MultiEchoLaserScan`: as [`LaserScan`], with any number of echoes of a ray.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct MultiEchoLaserScan {
    /// Time of the first ray, and frame.
    pub header: Header,
    /// Direction of the first ray, radians about z from x.
    pub angle_min: f32,
    /// Direction of the last ray.
    pub angle_max: f32,
    /// From one ray to the next.
    pub angle_increment: f32,
    /// From one ray to the next, seconds.
    pub time_increment: f32,
    /// From one scan to the next, seconds.
    pub scan_time: f32,
    /// Least range that is valid, metres.
    pub range_min: f32,
    /// Largest.
    pub range_max: f32,
    /// Metres.
    pub ranges: Vec<LaserEcho>,
    /// In the sensor's own unit; empty where it gives none.
    pub intensities: Vec<LaserEcho>,
}

/// A point of [`CustomMsg`].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct CustomPoint {
    /// After the message's `timebase`, nanoseconds.
    pub offset_time: u32,
    /// Metres.
    pub x: f32,
    /// Metres.
    pub y: f32,
    /// Metres.
    pub z: f32,
    /// 0 to 255.
    pub reflectivity: u8,
    /// Livox's tag: return and noise.
    pub tag: u8,
    /// Number of the laser, which draws a rosette: no ring.
    pub line: u8,
}

/// `livox_ros_driver2/msg/CustomMsg`, and `livox_ros_driver/CustomMsg` of ROS 1.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CustomMsg {
    /// Stamp and frame.
    pub header: Header,
    /// Time of the first point, nanoseconds by the sensor's clock.
    pub timebase: u64,
    /// How many points there are.
    pub point_num: u32,
    /// Number of the sensor.
    pub lidar_id: u8,
    /// Reserved.
    pub rsvd: [u8; 3],
    /// The points.
    pub points: Vec<CustomPoint>,
}
