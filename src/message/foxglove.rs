//! Foxglove's protobuf messages, with the field numbers of its published schemas.

use crate::base::Result;
use crate::message::decode_error;

/// `google.protobuf.Timestamp`.
#[derive(Clone, Copy, PartialEq, Eq, prost::Message)]
pub struct Timestamp {
    /// Seconds since the Unix epoch.
    #[prost(int64, tag = "1")]
    pub seconds: i64,
    /// Nanoseconds, 0 to 999,999,999.
    #[prost(int32, tag = "2")]
    pub nanos: i32,
}

/// Nanoseconds since the Unix epoch.
///
/// # Errors
/// [`crate::Error::Decode`] where the stamp is missing, before 1970 or out of range.
pub fn stamp_ns(timestamp: Option<Timestamp>) -> Result<u64> {
    let whole = timestamp.and_then(|time| {
        let nanos = u64::try_from(time.nanos).ok().filter(|&nanos| nanos < 1_000_000_000)?;
        u64::try_from(time.seconds).ok()?.checked_mul(1_000_000_000)?.checked_add(nanos)
    });
    whole.ok_or_else(|| decode_error("stamp", "is missing or out of range"))
}

/// `foxglove.Vector3`.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Vector3 {
    /// Metres.
    #[prost(double, tag = "1")]
    pub x: f64,
    /// Metres.
    #[prost(double, tag = "2")]
    pub y: f64,
    /// Metres.
    #[prost(double, tag = "3")]
    pub z: f64,
}

/// `foxglove.Quaternion`.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Quaternion {
    /// i.
    #[prost(double, tag = "1")]
    pub x: f64,
    /// j.
    #[prost(double, tag = "2")]
    pub y: f64,
    /// k.
    #[prost(double, tag = "3")]
    pub z: f64,
    /// Real part.
    #[prost(double, tag = "4")]
    pub w: f64,
}

/// `foxglove.RawImage`; samples of more than a byte are little-endian.
#[derive(Clone, PartialEq, Eq, prost::Message)]
pub struct RawImage {
    /// Time of capture.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Pixels.
    #[prost(fixed32, tag = "2")]
    pub width: u32,
    /// Pixels.
    #[prost(fixed32, tag = "3")]
    pub height: u32,
    /// Name of the pixel layout, such as `rgb8` or `16UC1`.
    #[prost(string, tag = "4")]
    pub encoding: String,
    /// Bytes from one row to the next.
    #[prost(fixed32, tag = "5")]
    pub step: u32,
    /// `step * height` bytes.
    #[prost(bytes = "vec", tag = "6")]
    pub data: Vec<u8>,
    /// Optical frame.
    #[prost(string, tag = "7")]
    pub frame_id: String,
}

/// `foxglove.CompressedImage`.
#[derive(Clone, PartialEq, Eq, prost::Message)]
pub struct CompressedImage {
    /// Time of capture.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// The file.
    #[prost(bytes = "vec", tag = "2")]
    pub data: Vec<u8>,
    /// `jpeg` or `png` (`webp` and `avif` are not supported).
    #[prost(string, tag = "3")]
    pub format: String,
    /// Optical frame.
    #[prost(string, tag = "4")]
    pub frame_id: String,
}

/// `foxglove.CameraCalibration`.
#[derive(Clone, PartialEq, prost::Message)]
pub struct CameraCalibration {
    /// Time of the calibration.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Pixels.
    #[prost(fixed32, tag = "2")]
    pub width: u32,
    /// Pixels.
    #[prost(fixed32, tag = "3")]
    pub height: u32,
    /// `plumb_bob`, `rational_polynomial` or `kannala_brandt`.
    #[prost(string, tag = "4")]
    pub distortion_model: String,
    /// Distortion coefficients (`D`).
    #[prost(double, repeated, tag = "5")]
    pub d: Vec<f64>,
    /// Intrinsics (`K`), row-major 3x3.
    #[prost(double, repeated, tag = "6")]
    pub k: Vec<f64>,
    /// Rectification (`R`), row-major 3x3.
    #[prost(double, repeated, tag = "7")]
    pub r: Vec<f64>,
    /// Projection (`P`), row-major 3x4.
    #[prost(double, repeated, tag = "8")]
    pub p: Vec<f64>,
    /// Optical frame.
    #[prost(string, tag = "9")]
    pub frame_id: String,
}

/// `foxglove.FrameTransform`: pose of the child in the parent.
#[derive(Clone, PartialEq, prost::Message)]
pub struct FrameTransform {
    /// Time of the transform.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Parent frame.
    #[prost(string, tag = "2")]
    pub parent_frame_id: String,
    /// Child frame.
    #[prost(string, tag = "3")]
    pub child_frame_id: String,
    /// Metres.
    #[prost(message, optional, tag = "4")]
    pub translation: Option<Vector3>,
    /// Unit quaternion.
    #[prost(message, optional, tag = "5")]
    pub rotation: Option<Quaternion>,
}

/// `foxglove.FrameTransforms`.
#[derive(Clone, PartialEq, prost::Message)]
pub struct FrameTransforms {
    /// The transforms.
    #[prost(message, repeated, tag = "1")]
    pub transforms: Vec<FrameTransform>,
}

/// `foxglove.Pose`.
#[derive(Clone, Copy, PartialEq, prost::Message)]
pub struct Pose {
    /// Metres.
    #[prost(message, optional, tag = "1")]
    pub position: Option<Vector3>,
    /// Unit quaternion.
    #[prost(message, optional, tag = "2")]
    pub orientation: Option<Quaternion>,
}

/// `foxglove.PackedElementField`.
#[derive(Clone, PartialEq, Eq, prost::Message)]
pub struct PackedElementField {
    /// Such as `x` or `intensity`.
    #[prost(string, tag = "1")]
    pub name: String,
    /// Bytes from the start of the point.
    #[prost(fixed32, tag = "2")]
    pub offset: u32,
    /// Type of its number.
    #[prost(enumeration = "packed_element_field::NumericType", tag = "3")]
    pub r#type: i32,
}

/// What belongs to [`PackedElementField`].
pub mod packed_element_field {
    /// Types of numbers, all little-endian.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, prost::Enumeration)]
    #[repr(i32)]
    pub enum NumericType {
        /// Not stated.
        Unknown = 0,
        /// 8 bits.
        Uint8 = 1,
        /// 8 bits, signed.
        Int8 = 2,
        /// 16 bits.
        Uint16 = 3,
        /// 16 bits, signed.
        Int16 = 4,
        /// 32 bits.
        Uint32 = 5,
        /// 32 bits, signed.
        Int32 = 6,
        /// 32-bit float.
        Float32 = 7,
        /// 64-bit float.
        Float64 = 8,
    }
}

/// `foxglove.PointCloud`.
#[derive(Clone, PartialEq, prost::Message)]
pub struct PointCloud {
    /// Time of the cloud.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Frame that the pose is given in.
    #[prost(string, tag = "2")]
    pub frame_id: String,
    /// Pose of the cloud's origin in the frame.
    #[prost(message, optional, tag = "3")]
    pub pose: Option<Pose>,
    /// Bytes from one point to the next.
    #[prost(fixed32, tag = "4")]
    pub point_stride: u32,
    /// What a point holds.
    #[prost(message, repeated, tag = "5")]
    pub fields: Vec<PackedElementField>,
    /// The points.
    #[prost(bytes = "vec", tag = "6")]
    pub data: Vec<u8>,
}

/// `foxglove.LaserScan`: ranges in the plane z = 0 of the pose.
#[derive(Clone, PartialEq, prost::Message)]
pub struct LaserScan {
    /// Time of the scan.
    #[prost(message, optional, tag = "1")]
    pub timestamp: Option<Timestamp>,
    /// Frame that the pose is given in.
    #[prost(string, tag = "2")]
    pub frame_id: String,
    /// Pose of the scan's origin in the frame.
    #[prost(message, optional, tag = "3")]
    pub pose: Option<Pose>,
    /// Direction of the first ray, radians about z from x.
    #[prost(double, tag = "4")]
    pub start_angle: f64,
    /// Direction of the last ray.
    #[prost(double, tag = "5")]
    pub end_angle: f64,
    /// Metres; the rays lie evenly between the two directions.
    #[prost(double, repeated, tag = "6")]
    pub ranges: Vec<f64>,
    /// In the sensor's own unit; empty where it gives none.
    #[prost(double, repeated, tag = "7")]
    pub intensities: Vec<f64>,
}

/// A message from its protobuf bytes; allocates no more than a few times the payload's size.
///
/// # Errors
/// [`crate::Error::Decode`] with `what`.
pub fn decode_protobuf<T: prost::Message + Default>(what: &str, payload: &[u8]) -> Result<T> {
    T::decode(payload).map_err(|error| decode_error(what, error.to_string()))
}
