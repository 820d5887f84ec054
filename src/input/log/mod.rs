//! Recordings as logs of messages, read as a stream: MCAP with ROS 2 (CDR), ROS 1 or Foxglove
//! (protobuf) messages, and ROS 1 bags.

mod camera;
mod choose;
mod decode;
mod file;
mod layout;
mod lidar;
mod motion;
mod odometry;
mod order;
mod reader;
mod reading;
mod records;
mod scans;
mod sdk;
mod sensor;
mod source;
mod topics;
mod track;
mod unread;

pub use crate::input::log::choose::Contents;
pub(crate) use crate::input::log::choose::{contents, lidar_log};
pub(crate) use crate::input::log::file::LogFile;
pub use crate::input::log::reader::LogReader;
pub(crate) use crate::input::log::reading::Log;
pub(crate) use crate::input::log::records::{Record, Records};
pub use crate::input::log::scans::LogScans;
pub(crate) use crate::input::log::source::LogSource;
