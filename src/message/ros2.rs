//! ROS 2 messages in CDR: plain structs with the fields in ROS order, both ways.

use byteorder::{BigEndian, LittleEndian};
use glam::{DQuat, DVec3};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::base::Result;
use crate::base::Rigid;
use crate::message::decode_error;
use crate::sensor::{CameraModel, Distortion};

/// `builtin_interfaces/msg/Time`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Time {
    /// Seconds since the Unix epoch.
    pub sec: i32,
    /// Nanoseconds, 0 to 999,999,999.
    pub nanosec: u32,
}

impl Time {
    /// Nanoseconds since the Unix epoch.
    ///
    /// # Errors
    /// [`crate::Error::Decode`] for times before 1970 and nanoseconds of a whole second or more.
    pub fn stamp_ns(self) -> Result<u64> {
        match u64::try_from(self.sec) {
            Ok(sec) if self.nanosec < 1_000_000_000 => Ok(sec * 1_000_000_000 + u64::from(self.nanosec)),
            _ => Err(decode_error("stamp", "seconds or nanoseconds are out of range")),
        }
    }

    /// The time of a stamp in nanoseconds; later than what ROS can say (2038) stays at its last second.
    pub fn from_stamp_ns(stamp_ns: u64) -> Self {
        let sec = i32::try_from(stamp_ns / 1_000_000_000).unwrap_or(i32::MAX);
        let nanosec = u32::try_from(stamp_ns % 1_000_000_000).unwrap_or_default();
        Self { sec, nanosec }
    }
}

/// `std_msgs/msg/Header`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// Time of capture.
    pub stamp: Time,
    /// Frame of the data.
    pub frame_id: String,
}

impl Header {
    /// At `stamp_ns` nanoseconds in frame `frame_id`.
    pub fn new(stamp_ns: u64, frame_id: &str) -> Self {
        Self { stamp: Time::from_stamp_ns(stamp_ns), frame_id: frame_id.into() }
    }
}

/// `geometry_msgs/msg/Vector3`, and `Point`, which has the same fields.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    /// Metres or the like.
    pub x: f64,
    /// Metres or the like.
    pub y: f64,
    /// Metres or the like.
    pub z: f64,
}

/// `geometry_msgs/msg/Quaternion`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// i.
    pub x: f64,
    /// j.
    pub y: f64,
    /// k.
    pub z: f64,
    /// Real part.
    pub w: f64,
}

impl From<DVec3> for Vector3 {
    fn from(DVec3 { x, y, z }: DVec3) -> Self {
        Self { x, y, z }
    }
}

impl From<DQuat> for Quaternion {
    fn from(DQuat { x, y, z, w }: DQuat) -> Self {
        Self { x, y, z, w }
    }
}

impl Default for Quaternion {
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

/// `geometry_msgs/msg/Transform`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    /// Metres.
    pub translation: Vector3,
    /// Unit quaternion.
    pub rotation: Quaternion,
}

impl From<Rigid> for Transform {
    fn from(rigid: Rigid) -> Self {
        Self { translation: rigid.translation_m.into(), rotation: rigid.rotation.into() }
    }
}

/// `geometry_msgs/msg/Pose`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Metres.
    pub position: Vector3,
    /// Unit quaternion.
    pub orientation: Quaternion,
}

/// `geometry_msgs/msg/TransformStamped`: pose of `child_frame_id` in `header.frame_id`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    /// Stamp and parent frame.
    pub header: Header,
    /// Child frame.
    pub child_frame_id: String,
    /// Parent from child.
    pub transform: Transform,
}

/// `tf2_msgs/msg/TFMessage`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TFMessage {
    /// The transforms.
    pub transforms: Vec<TransformStamped>,
}

/// `geometry_msgs/msg/PoseWithCovariance`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PoseWithCovariance {
    /// The pose.
    pub pose: Pose,
    /// Six rows of six: x, y, z, then rotations about them.
    pub covariance: [[f64; 6]; 6],
}

/// `nav_msgs/msg/Odometry` up to the pose; the twist that follows is not read.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OdometryPose {
    /// Stamp and fixed frame.
    pub header: Header,
    /// Frame of the robot.
    pub child_frame_id: String,
    /// Pose of the robot in the fixed frame.
    pub pose: PoseWithCovariance,
}

/// `geometry_msgs/msg/PoseStamped`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PoseStamped {
    /// Stamp and frame of the pose.
    pub header: Header,
    /// The pose.
    pub pose: Pose,
}

/// `sensor_msgs/msg/Image`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Image {
    /// Stamp and optical frame.
    pub header: Header,
    /// Pixels.
    pub height: u32,
    /// Pixels.
    pub width: u32,
    /// Name of the pixel layout, such as `rgb8` or `16UC1`.
    pub encoding: String,
    /// Whether samples of more than a byte are big-endian (0 or 1).
    pub is_bigendian: u8,
    /// Bytes from one row to the next.
    pub step: u32,
    /// `step * height` bytes.
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
}

/// `sensor_msgs/msg/CompressedImage`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CompressedImage {
    /// Stamp and optical frame.
    pub header: Header,
    /// Such as `jpeg`, `rgb8; jpeg compressed bgr8` or `16UC1; compressedDepth png`.
    pub format: String,
    /// The file.
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
}

/// `sensor_msgs/msg/RegionOfInterest`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RegionOfInterest {
    /// Pixels.
    pub x_offset: u32,
    /// Pixels.
    pub y_offset: u32,
    /// Pixels.
    pub height: u32,
    /// Pixels.
    pub width: u32,
    /// Whether a rectified region is meant.
    pub do_rectify: bool,
}

/// `sensor_msgs/msg/CameraInfo`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct CameraInfo {
    /// Stamp and optical frame.
    pub header: Header,
    /// Pixels.
    pub height: u32,
    /// Pixels.
    pub width: u32,
    /// `plumb_bob`, `rational_polynomial` or `equidistant`.
    pub distortion_model: String,
    /// Distortion coefficients.
    pub d: Vec<f64>,
    /// Intrinsics, row-major 3x3.
    pub k: [f64; 9],
    /// Rectification, row-major 3x3.
    pub r: [f64; 9],
    /// Projection, row-major 3x4.
    pub p: [f64; 12],
    /// Pixels merged in x; 0 means 1.
    pub binning_x: u32,
    /// Pixels merged in y; 0 means 1.
    pub binning_y: u32,
    /// The part of the sensor that the image shows; all 0 means all of it.
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
            Distortion::Fisheye(k) => ("equidistant", k.to_vec()),
        };
        Self {
            header,
            height,
            width,
            distortion_model: distortion_model.into(),
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

/// `sensor_msgs/msg/PointField`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointField {
    /// Such as `x` or `intensity`.
    pub name: String,
    /// Bytes from the start of the point.
    pub offset: u32,
    /// 1 to 8: i8, u8, i16, u16, i32, u32, f32, f64.
    pub datatype: u8,
    /// Numbers in the field.
    pub count: u32,
}

/// `sensor_msgs/msg/PointCloud2`.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointCloud2 {
    /// Stamp and frame.
    pub header: Header,
    /// Rows; 1 where the cloud is not organized.
    pub height: u32,
    /// Points in a row.
    pub width: u32,
    /// What a point holds.
    pub fields: Vec<PointField>,
    /// Whether numbers are big-endian (0 or 1).
    pub is_bigendian: u8,
    /// Bytes from one point to the next.
    pub point_step: u32,
    /// Bytes from one row to the next.
    pub row_step: u32,
    /// `row_step * height` bytes.
    #[serde(with = "serde_bytes")]
    pub data: Vec<u8>,
    /// Whether all points are finite (0 or 1).
    pub is_dense: u8,
}

/// A message from its encapsulation: a header of four bytes, whose second says the byte order, then CDR.
/// Allocates no more than the payload's own size; bytes after the message are ignored.
///
/// # Errors
/// [`crate::Error::Decode`] with `what` for other encapsulations and for messages that end early.
pub fn decode_cdr<T: DeserializeOwned>(what: &str, payload: &[u8]) -> Result<T> {
    let Some((header, body)) = payload.split_first_chunk::<4>() else {
        return Err(decode_error(what, format!("{} bytes are too few for a CDR header", payload.len())));
    };
    let decoded = match header[..2] {
        [0, 0] => cdr_encoding::from_bytes::<T, BigEndian>(body),
        [0, 1] => cdr_encoding::from_bytes::<T, LittleEndian>(body),
        [a, b] => {
            let reason = format!("encapsulation {a:#04x} {b:#04x} is not plain CDR (0x00 0x00 or 0x00 0x01)");
            return Err(decode_error(what, reason));
        }
        _ => return Err(decode_error(what, "no CDR header")),
    };
    decoded.map(|(message, _)| message).map_err(|error| decode_error(what, error.to_string()))
}

/// The encapsulated little-endian CDR of a message.
///
/// # Errors
/// [`crate::Error::Decode`] with `what` for sequences too long for CDR.
pub fn encode_cdr<T: Serialize>(what: &str, message: &T) -> Result<Vec<u8>> {
    let mut payload = vec![0, 1, 0, 0];
    cdr_encoding::to_writer::<T, LittleEndian, _>(&mut payload, message)
        .map_err(|error| decode_error(what, error.to_string()))?;
    Ok(payload)
}
