//! ROS messages of lidars other than `PointCloud2`: flat scans, the clouds of old, and the Livox driver's own.

use serde::{Deserialize, Serialize};

use crate::message::ros2::Header;

/// Ranges in one plane; `R`: what there is of a ray.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct FlatScan<R> {
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
    pub ranges: Vec<R>,
    /// In the sensor's own unit; empty where it gives none.
    pub intensities: Vec<R>,
}

/// `sensor_msgs/msg/LaserScan`: a range of each ray.
pub type LaserScan = FlatScan<f32>;

/// `sensor_msgs/msg/MultiEchoLaserScan`: any number of echoes of a ray.
pub type MultiEchoLaserScan = FlatScan<LaserEcho>;

/// `sensor_msgs/msg/LaserEcho`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct LaserEcho {
    /// Ranges, or intensities, of one ray, the nearest first.
    pub echoes: Vec<f32>,
}

/// `geometry_msgs/msg/Point32`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Point32 {
    /// Metres.
    pub x: f32,
    /// Metres.
    pub y: f32,
    /// Metres.
    pub z: f32,
}

/// `sensor_msgs/msg/ChannelFloat32`: a number of each point.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ChannelFloat32 {
    /// Such as `intensity`.
    pub name: String,
    /// One for each point.
    pub values: Vec<f32>,
}

/// `sensor_msgs/msg/PointCloud`, which came before `PointCloud2`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct PointCloud {
    /// Stamp and frame.
    pub header: Header,
    /// Places.
    pub points: Vec<Point32>,
    /// What else there is of the points.
    pub channels: Vec<ChannelFloat32>,
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
