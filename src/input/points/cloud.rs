//! `sensor_msgs/PointCloud2` (ROS 1 and ROS 2), `sensor_msgs/PointCloud` and `foxglove.PointCloud`, of any layout of fields.

use glam::DVec3;

use crate::base::Result;
use crate::base::Rigid;
pub(crate) use crate::input::points::fields::{INTENSITY, RING, TIME};
use crate::input::points::fields::{narrow, scan};
use crate::input::points::table::{Column, Scalar, Table, is_named};
use crate::input::points::{Options, check_points};
use crate::message::foxglove;
use crate::message::foxglove::packed_element_field::NumericType;
use crate::message::lidar::PointCloud;
use crate::message::{bare_frame, decode_error, ros2};
use crate::sensor::Scan;

/// The first of a cloud's fields with one of the names, as they are read.
pub(crate) fn find_field<'a>(fields: &'a [String], names: &[&str]) -> Option<&'a String> {
    names.iter().find_map(|name| fields.iter().find(|field| is_named(field, name)))
}

const ROS: &str = "sensor_msgs/PointCloud2";
const OLD: &str = "sensor_msgs/PointCloud";
const FOXGLOVE: &str = "foxglove.PointCloud";

/// The start of a `sensor_msgs/PointCloud2`.
#[derive(Debug, serde::Deserialize)]
#[serde(rename = "PointCloud2")]
pub(crate) struct CloudHead {
    #[expect(dead_code, reason = "it stands before the size")]
    header: ros2::Header,
    height: u32,
    width: u32,
}

/// Refuses a cloud that is too large, before memory is taken for it.
///
/// # Errors
/// [`crate::Error::Decode`] with the number of points.
pub(crate) fn check_size(head: &CloudHead) -> Result<()> {
    check_points(ROS, u64::from(head.height) * u64::from(head.width))
}

/// The scan in a ROS message. Read are `x`, `y`, `z`, and where present `intensity` (`reflectivity`, `i`, `signal` and the like),
/// `ring` (`channel`), `time` (`t`, `timestamp`, `offset_time`; unit and start follow from type and size), `return_type` and
/// `label`.
/// Clouds of more than one row are taken as organized.
///
/// # Errors
/// [`crate::Error::Decode`]: a `point_step` of 0, rows or data that are too short, fields of unknown type, fields that
/// are missing, doubled, overlap or run past the point.
pub fn from_ros(message: ros2::PointCloud2, options: &Options) -> Result<Scan> {
    let [height, width, point_step, row_step] =
        [message.height, message.width, message.point_step, message.row_step].map(|value| value as usize);
    let stamp_ns = message.header.stamp.stamp_ns()?;
    if point_step == 0 {
        return Err(decode_error(ROS, "point_step is 0"));
    }
    if width.checked_mul(point_step).is_none_or(|least| least > row_step) {
        let reason = format!("row_step {row_step} is less than {width} points of {point_step} bytes");
        return Err(decode_error(ROS, reason));
    }
    if row_step.checked_mul(height).is_none_or(|whole| whole > message.data.len()) {
        let reason =
            format!("{height} rows of {row_step} bytes do not fit {} bytes of data", message.data.len());
        return Err(decode_error(ROS, reason));
    }
    let columns = message.fields.into_iter().map(|field| ros_column(field, point_step));
    let table = Table {
        what: ROS,
        bytes: &message.data,
        big_endian: message.is_bigendian != 0,
        height,
        width,
        row_step,
        columns: columns.collect::<Result<_>>()?,
    };
    scan(&table, stamp_ns, bare_frame(message.header.frame_id), options)
}

fn ros_column(field: ros2::PointField, point_step: usize) -> Result<Column> {
    let scalar = match field.datatype {
        1 => Scalar::I8,
        2 => Scalar::U8,
        3 => Scalar::I16,
        4 => Scalar::U16,
        5 => Scalar::I32,
        6 => Scalar::U32,
        7 => Scalar::F32,
        8 => Scalar::F64,
        other => return Err(decode_error(ROS, format!("field `{}` is of type {other}", field.name))),
    };
    column(ROS, field.name, scalar, field.offset, point_step)
}

/// A column of points that lie one after the other.
fn column(what: &str, name: String, scalar: Scalar, offset: u32, stride: usize) -> Result<Column> {
    let offset = offset as usize;
    if offset.checked_add(scalar.size()).is_none_or(|end| end > stride) {
        let reason = format!("field `{name}` at offset {offset} runs past the point's {stride} bytes");
        return Err(decode_error(what, reason));
    }
    Ok(Column { name, scalar, declared: scalar, offset, stride })
}

/// The scan in a message of the type that came before `PointCloud2`, as [`from_ros`]; its channels are fields.
///
/// # Errors
/// [`crate::Error::Decode`]: too many points, a channel without one number for each point, fields that are missing or doubled.
pub fn from_old(message: PointCloud, options: &Options) -> Result<Scan> {
    let PointCloud { header, points, channels } = message;
    check_points(OLD, points.len() as u64)?;
    if let Some(channel) = channels.iter().find(|channel| channel.values.len() != points.len()) {
        let (name, values) = (&channel.name, channel.values.len());
        return Err(decode_error(
            OLD,
            format!("channel `{name}` has {values} values for {} points", points.len()),
        ));
    }
    let names = ["x", "y", "z"].map(String::from).into_iter();
    let names: Vec<String> = names.chain(channels.iter().map(|channel| channel.name.clone())).collect();
    let stride = names.len() * Scalar::F32.size();
    let mut bytes = Vec::with_capacity(stride * points.len());
    for (at, point) in points.iter().enumerate() {
        let numbers = [point.x, point.y, point.z].into_iter();
        numbers
            .chain(channels.iter().map(|channel| channel.values[at]))
            .for_each(|number| bytes.extend(number.to_le_bytes()));
    }
    let columns = names.into_iter().enumerate().map(|(at, name)| Column {
        name,
        scalar: Scalar::F32,
        declared: Scalar::F32,
        offset: at * Scalar::F32.size(),
        stride,
    });
    let table = Table {
        what: OLD,
        bytes: &bytes,
        big_endian: false,
        height: 1,
        width: points.len(),
        row_step: bytes.len(),
        columns: columns.collect(),
    };
    scan(&table, header.stamp.stamp_ns()?, bare_frame(header.frame_id), options)
}

/// The scan in a Foxglove message, as [`from_ros`]; a pose that the message gives is applied to the points.
///
/// # Errors
/// As [`from_ros`], and [`crate::Error::Decode`] for a pose that is none.
pub fn from_foxglove(message: &foxglove::PointCloud, options: &Options) -> Result<Scan> {
    let stride = message.point_stride as usize;
    if stride == 0 {
        return Err(decode_error(FOXGLOVE, "point_stride is 0"));
    }
    if !message.data.len().is_multiple_of(stride) {
        let reason = format!("{} bytes of data are no points of {stride} bytes", message.data.len());
        return Err(decode_error(FOXGLOVE, reason));
    }
    check_points(FOXGLOVE, (message.data.len() / stride) as u64)?;
    let columns = message.fields.iter().map(|field| {
        let scalar = match field.r#type() {
            NumericType::Uint8 => Scalar::U8,
            NumericType::Int8 => Scalar::I8,
            NumericType::Uint16 => Scalar::U16,
            NumericType::Int16 => Scalar::I16,
            NumericType::Uint32 => Scalar::U32,
            NumericType::Int32 => Scalar::I32,
            NumericType::Float32 => Scalar::F32,
            NumericType::Float64 => Scalar::F64,
            NumericType::Unknown => {
                return Err(decode_error(FOXGLOVE, format!("field `{}` is of unknown type", field.name)));
            }
        };
        column(FOXGLOVE, field.name.clone(), scalar, field.offset, stride)
    });
    let table = Table {
        what: FOXGLOVE,
        bytes: &message.data,
        big_endian: false,
        height: 1,
        width: message.data.len() / stride,
        row_step: message.data.len(),
        columns: columns.collect::<Result<_>>()?,
    };
    let stamp_ns = foxglove::stamp_ns(message.timestamp)?;
    let mut scan = scan(&table, stamp_ns, bare_frame(message.frame_id.clone()), options)?;
    place(&mut scan, FOXGLOVE, message.pose.as_ref())?;
    Ok(scan)
}

/// Applies the pose that a message gives of its points' origin.
///
/// # Errors
/// [`crate::Error::Decode`] for a pose that is none.
pub(super) fn place(scan: &mut Scan, what: &str, pose: Option<&foxglove::Pose>) -> Result<()> {
    let pose = pose.map(|pose| frame_from_cloud(what, pose)).transpose()?;
    if let Some(pose) = pose.filter(|&pose| pose != Rigid::IDENTITY) {
        for point in &mut scan.points {
            let placed = pose.transform_point(DVec3::from(point.position_m().map(f64::from)));
            [point.x_m, point.y_m, point.z_m] = placed.to_array().map(narrow);
            if !point.position_m().iter().all(|metres| metres.is_finite()) {
                return Err(decode_error(what, "its pose takes points farther away than numbers go"));
            }
        }
    }
    Ok(())
}

/// What a pose leaves out is 0 and no rotation.
fn frame_from_cloud(what: &str, pose: &foxglove::Pose) -> Result<Rigid> {
    let t = pose.position.unwrap_or_default();
    let q = pose.orientation.unwrap_or(foxglove::Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 });
    Rigid::new([t.x, t.y, t.z], [q.x, q.y, q.z, q.w])
        .ok_or_else(|| decode_error(what, "its pose is not finite or has no rotation"))
}
