//! Recordings as logs of messages, read as a stream: MCAP with ROS 2 (CDR), ROS 1 or Foxglove
//! (protobuf) messages, ROS 1 bags, and rosbag2's SQLite files and folders.

mod camera;
mod cameras;
mod choose;
mod decode;
mod file;
mod files;
mod inventory;
mod layout;
mod lidar;
#[cfg(feature = "ros2")]
mod live;
mod look;
mod metadata;
mod motion;
mod names;
mod odometry;
mod order;
mod reader;
mod reading;
mod records;
mod scans;
mod sdk;
mod sensor;
mod source;
mod splits;
mod taking;
mod topics;
mod track;
mod unread;

pub use crate::input::log::choose::Contents;
pub(crate) use crate::input::log::choose::{contents, lidar_log};
pub(crate) use crate::input::log::file::LogFile;
pub(in crate::input) use crate::input::log::files::Told;
pub(crate) use crate::input::log::files::{Format, LogFiles};
pub(crate) use crate::input::log::inventory::inventory;
#[cfg(feature = "ros2")]
pub(crate) use crate::input::log::live::{LiveSource, LiveTopic};
pub use crate::input::log::reader::LogReader;
pub(crate) use crate::input::log::reading::Log;
pub(crate) use crate::input::log::records::{MAX_MESSAGE_BYTES, Record, Records, too_large};
pub use crate::input::log::scans::LogScans;
#[cfg(feature = "ros2")]
pub(crate) use crate::input::log::sdk::is_image_of_sdk;
pub(crate) use crate::input::log::source::LogSource;
#[cfg(feature = "ros2")]
pub(crate) use crate::input::log::splits::{Splits, Survey};
