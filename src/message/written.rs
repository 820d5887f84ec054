//! ROS 2 messages that limpid only writes, and the names of all that it writes; fields in the order of
//! their definitions, which CDR depends on.

use serde::Serialize;
use serde::ser::SerializeTuple as _;
use serde_bytes::Bytes;

use crate::message::ros2::{CameraInfo, CompressedImage, Header, Image, PointCloud2, Pose, TFMessage, Time};

/// A message with the name of its type.
pub trait RosMessage: Serialize {
    /// As in `nav_msgs/msg/OccupancyGrid`.
    const TYPE: &'static str;
}

macro_rules! ros_types {
    ($($message:ident $(<$life:lifetime>)? = $name:literal),* $(,)?) => {
        $(impl $(<$life>)? RosMessage for $message $(<$life>)? {
            const TYPE: &'static str = $name;
        })*
    };
}

ros_types![
    OccupancyGrid<'a> = "nav_msgs/msg/OccupancyGrid",
    Costmap<'a> = "nav2_msgs/msg/Costmap",
    Image = "sensor_msgs/msg/Image",
    CompressedImage = "sensor_msgs/msg/CompressedImage",
    CameraInfo = "sensor_msgs/msg/CameraInfo",
    PointCloud2 = "sensor_msgs/msg/PointCloud2",
    TFMessage = "tf2_msgs/msg/TFMessage",
    VelodyneScan = "velodyne_msgs/msg/VelodyneScan",
    DiagnosticArray = "diagnostic_msgs/msg/DiagnosticArray",
    RosString = "std_msgs/msg/String",
    FoxgloveGrid<'a> = "foxglove_msgs/msg/Grid",
];

/// `nav_msgs/MapMetaData`.
#[derive(Debug, Clone, Serialize)]
pub struct MapMetaData {
    /// When the map was made.
    pub map_load_time: Time,
    /// Metres a cell.
    pub resolution: f32,
    /// Cells along x.
    pub width: u32,
    /// Cells along y.
    pub height: u32,
    /// Corner of cell (0, 0).
    pub origin: Pose,
}

/// `nav_msgs/OccupancyGrid`.
#[derive(Debug, Clone, Serialize)]
pub struct OccupancyGrid<'a> {
    /// Stamp and map frame.
    pub header: Header,
    /// Geometry.
    pub info: MapMetaData,
    /// 0..=100 or -1 as bytes, row 0 = smallest y.
    pub data: &'a Bytes,
}

/// `nav2_msgs/CostmapMetaData`.
#[derive(Debug, Clone, Serialize)]
pub struct CostmapMetaData {
    /// When the map was made.
    pub map_load_time: Time,
    /// When the map was last updated.
    pub update_time: Time,
    /// Name of the costmap layer.
    pub layer: String,
    /// Metres a cell.
    pub resolution: f32,
    /// Cells along x.
    pub size_x: u32,
    /// Cells along y.
    pub size_y: u32,
    /// Corner of cell (0, 0).
    pub origin: Pose,
}

/// `nav2_msgs/Costmap`.
#[derive(Debug, Clone, Serialize)]
pub struct Costmap<'a> {
    /// Stamp and map frame.
    pub header: Header,
    /// Geometry.
    pub metadata: CostmapMetaData,
    /// Nav2 costs, row 0 = smallest y.
    pub data: &'a Bytes,
}

/// `diagnostic_msgs/KeyValue`.
#[derive(Debug, Clone, Serialize)]
pub struct KeyValue {
    /// What.
    pub key: String,
    /// How much.
    pub value: String,
}

/// `diagnostic_msgs/DiagnosticStatus`.
#[derive(Debug, Clone, Serialize)]
pub struct DiagnosticStatus {
    /// 0 OK, 1 WARN, 2 ERROR.
    pub level: u8,
    /// Which component.
    pub name: String,
    /// In words.
    pub message: String,
    /// Which device.
    pub hardware_id: String,
    /// Figures.
    pub values: Vec<KeyValue>,
}

/// `diagnostic_msgs/DiagnosticArray`.
#[derive(Debug, Clone, Serialize)]
pub struct DiagnosticArray {
    /// Stamp.
    pub header: Header,
    /// One entry per component.
    pub status: Vec<DiagnosticStatus>,
}

/// `std_msgs/String`.
#[derive(Debug, Clone, Serialize)]
pub struct RosString {
    /// The text.
    pub data: String,
}

/// `foxglove_msgs/Vector2`.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Vector2 {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
}

/// `foxglove_msgs/PackedElementField`.
#[derive(Debug, Clone, Serialize)]
pub struct PackedElementField {
    /// What.
    pub name: String,
    /// Bytes from the start of the cell.
    pub offset: u32,
    /// Type of its number: 1 `u8`, 7 `f32`; little-endian.
    pub r#type: u8,
}

/// `foxglove_msgs/Grid`.
#[derive(Debug, Clone, Serialize)]
pub struct FoxgloveGrid<'a> {
    /// Time of the grid.
    pub timestamp: Time,
    /// Frame that the pose is given in.
    pub frame_id: String,
    /// Corner of cell (0, 0).
    pub pose: Pose,
    /// Cells along x.
    pub column_count: u32,
    /// Size of a cell.
    pub cell_size: Vector2,
    /// Bytes from one row to the next.
    pub row_stride: u32,
    /// Bytes from one cell to the next.
    pub cell_stride: u32,
    /// What a cell holds.
    pub fields: Vec<PackedElementField>,
    /// The cells, row 0 = smallest y.
    pub data: &'a Bytes,
}

/// `velodyne_msgs/VelodynePacket`.
#[derive(Debug, Clone, Serialize)]
pub struct VelodynePacket {
    /// When it came.
    pub stamp: Time,
    /// As the sensor sends it.
    #[serde(serialize_with = "array")]
    pub data: [u8; 1206],
}

/// Bytes without a count before them.
fn array<S: serde::Serializer>(data: &[u8; 1206], serializer: S) -> Result<S::Ok, S::Error> {
    let mut tuple = serializer.serialize_tuple(data.len())?;
    data.iter().try_for_each(|byte| tuple.serialize_element(byte))?;
    tuple.end()
}

/// `velodyne_msgs/VelodyneScan`.
#[derive(Debug, Clone, Serialize)]
pub struct VelodyneScan {
    /// Stamp and the sensor's frame.
    pub header: Header,
    /// Of about a revolution.
    pub packets: Vec<VelodynePacket>,
}
