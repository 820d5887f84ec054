//! ROS 2 messages that are only sent and received live, and those that are only passed on.

use serde::{Deserialize, Serialize};
use serde_bytes::Bytes;

use crate::message::RosMessage;
use crate::message::ros2::{Header, PoseWithCovariance, Time, Vector3};

macro_rules! ros_types {
    ($($message:ident $(<$life:lifetime>)? = $name:literal),* $(,)?) => {
        $(impl $(<$life>)? RosMessage for $message $(<$life>)? {
            const TYPE: &'static str = $name;
        })*
    };
}

ros_types![
    Clock = "rosgraph_msgs/msg/Clock",
    Odometry = "nav_msgs/msg/Odometry",
    GridUpdate<'a> = "map_msgs/msg/OccupancyGridUpdate",
    SpeedLimit = "nav2_msgs/msg/SpeedLimit",
    Log<'a> = "rcl_interfaces/msg/Log",
];

/// `rosgraph_msgs/Clock`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Clock {
    /// Simulated time.
    pub clock: Time,
}

/// `geometry_msgs/TwistWithCovariance`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TwistWithCovariance {
    /// Metres a second.
    pub linear: Vector3,
    /// Radians a second.
    pub angular: Vector3,
    /// Six rows of six.
    pub covariance: [[f64; 6]; 6],
}

/// `nav_msgs/Odometry`, all of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Odometry {
    /// Stamp and fixed frame.
    pub header: Header,
    /// Frame of the robot.
    pub child_frame_id: String,
    /// Pose of the robot in the fixed frame.
    pub pose: PoseWithCovariance,
    /// Its motion in its own frame.
    pub twist: TwistWithCovariance,
}

/// `map_msgs/OccupancyGridUpdate`: a rectangle of a grid that was sent before.
#[derive(Debug, Clone, Serialize)]
pub struct GridUpdate<'a> {
    /// Stamp and frame of the grid.
    pub header: Header,
    /// First column.
    pub x: i32,
    /// First row.
    pub y: i32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// 0..=100 or -1 as bytes, row by row.
    pub data: &'a Bytes,
}

/// `nav2_msgs/SpeedLimit`.
#[derive(Debug, Clone, Serialize)]
pub struct SpeedLimit {
    /// Stamp.
    pub header: Header,
    /// Whether the limit is a share of the largest speed.
    pub percentage: bool,
    /// Percent, or metres a second; 0: no limit.
    pub speed_limit: f64,
}

/// `rcl_interfaces/Log`.
#[derive(Debug, Clone, Serialize)]
pub struct Log<'a> {
    /// When.
    pub stamp: Time,
    /// 20 INFO, 30 WARN, 40 ERROR.
    pub level: u8,
    /// The node.
    pub name: &'a str,
    /// In words.
    pub msg: &'a str,
    /// Source file.
    pub file: &'a str,
    /// Source function.
    pub function: &'a str,
    /// Source line.
    pub line: u32,
}
