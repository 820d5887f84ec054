//! ROS 2 messages that limpid writes; fields in the order of their definitions, which CDR depends on.

use serde::Serialize;
use serde_bytes::Bytes;

use crate::camera::{CameraModel, Distortion};
use crate::geometry::Rigid;

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
    Image<'a> = "sensor_msgs/msg/Image",
    CompressedImage<'a> = "sensor_msgs/msg/CompressedImage",
    CameraInfo = "sensor_msgs/msg/CameraInfo",
    TfMessage = "tf2_msgs/msg/TFMessage",
    DiagnosticArray = "diagnostic_msgs/msg/DiagnosticArray",
];

/// `builtin_interfaces/Time`.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Time {
    /// Seconds since the Unix epoch.
    pub sec: i32,
    /// Nanoseconds within the second.
    pub nanosec: u32,
}

impl Time {
    /// From nanoseconds since the Unix epoch; later than what ROS can say (2038) stays at its last second.
    pub fn from_ns(stamp_ns: u64) -> Self {
        let sec = i32::try_from(stamp_ns / 1_000_000_000).unwrap_or(i32::MAX);
        let nanosec = u32::try_from(stamp_ns % 1_000_000_000).unwrap_or_default();
        Self { sec, nanosec }
    }
}

/// `std_msgs/Header`.
#[derive(Debug, Clone, Serialize)]
pub struct Header {
    /// Time of the data.
    pub stamp: Time,
    /// Frame of the data.
    pub frame_id: String,
}

impl Header {
    /// At `stamp_ns` nanoseconds in frame `frame_id`.
    pub fn new(stamp_ns: u64, frame_id: &str) -> Self {
        Self { stamp: Time::from_ns(stamp_ns), frame_id: frame_id.to_owned() }
    }
}

/// `geometry_msgs/Pose` and `geometry_msgs/Transform`, which have the same layout.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Pose {
    /// Metres.
    pub translation_m: [f64; 3],
    /// Unit quaternion.
    pub rotation_xyzw: [f64; 4],
}

impl From<Rigid> for Pose {
    fn from(rigid: Rigid) -> Self {
        Self { translation_m: rigid.translation_m.to_array(), rotation_xyzw: rigid.rotation.to_array() }
    }
}

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

/// `sensor_msgs/Image`.
#[derive(Debug, Clone, Serialize)]
pub struct Image<'a> {
    /// Stamp and optical frame.
    pub header: Header,
    /// Pixels.
    pub height: u32,
    /// Pixels.
    pub width: u32,
    /// As in `16UC1`.
    pub encoding: &'a str,
    /// 1 where samples have their high byte first.
    pub is_bigendian: u8,
    /// Bytes a row.
    pub step: u32,
    /// `step * height` bytes from the top left.
    pub data: &'a Bytes,
}

/// `sensor_msgs/CompressedImage`.
#[derive(Debug, Clone, Serialize)]
pub struct CompressedImage<'a> {
    /// Stamp and optical frame.
    pub header: Header,
    /// As in `jpeg`.
    pub format: &'a str,
    /// The file's bytes.
    pub data: &'a Bytes,
}

/// `sensor_msgs/RegionOfInterest`; all zero: the whole image.
#[derive(Debug, Clone, Copy, Default, Serialize)]
pub struct RegionOfInterest {
    /// Pixels.
    pub x_offset: u32,
    /// Pixels.
    pub y_offset: u32,
    /// Pixels.
    pub height: u32,
    /// Pixels.
    pub width: u32,
    /// Whether the region is to be rectified.
    pub do_rectify: bool,
}

/// `sensor_msgs/CameraInfo`.
#[derive(Debug, Clone, Serialize)]
pub struct CameraInfo {
    /// Stamp and optical frame of the image.
    pub header: Header,
    /// Pixels.
    pub height: u32,
    /// Pixels.
    pub width: u32,
    /// `plumb_bob` or `rational_polynomial`.
    pub distortion_model: &'static str,
    /// Distortion coefficients.
    pub d: Vec<f64>,
    /// Intrinsic matrix, row-major.
    pub k: [f64; 9],
    /// Rectification, row-major: identity for a single camera.
    pub r: [f64; 9],
    /// Projection of the rectified image, row-major.
    pub p: [f64; 12],
    /// 0 as 1: no binning.
    pub binning_x: u32,
    /// 0 as 1: no binning.
    pub binning_y: u32,
    /// Part of the sensor that the image shows.
    pub roi: RegionOfInterest,
}

impl CameraInfo {
    /// Calibration of one camera: R is the identity and P is K without an offset.
    pub fn new(header: Header, camera: &CameraModel) -> Self {
        let CameraModel { width, height, fx, fy, cx, cy, distortion } = *camera;
        let (distortion_model, d) = match distortion {
            Distortion::None => ("plumb_bob", vec![0.0; 5]),
            Distortion::PlumbBob(k) => ("plumb_bob", k.to_vec()),
            Distortion::RationalPolynomial(k) => ("rational_polynomial", k.to_vec()),
        };
        Self {
            header,
            height,
            width,
            distortion_model,
            d,
            k: [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
            r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            p: [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
            binning_x: 0,
            binning_y: 0,
            roi: RegionOfInterest::default(),
        }
    }
}

/// `geometry_msgs/TransformStamped`.
#[derive(Debug, Clone, Serialize)]
pub struct TransformStamped {
    /// Stamp and parent frame.
    pub header: Header,
    /// Child frame.
    pub child_frame_id: String,
    /// Parent from child.
    pub transform: Pose,
}

/// `tf2_msgs/TFMessage`.
#[derive(Debug, Clone, Serialize)]
pub struct TfMessage {
    /// Any number of transforms.
    pub transforms: Vec<TransformStamped>,
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
    /// 0 OK, 1 WARN.
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
