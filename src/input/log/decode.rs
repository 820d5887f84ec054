//! Messages of the topics that are read, to events.

use crate::base::Result;
use crate::base::Rigid;
use crate::input::calibration::Calibration;
use crate::input::event::TransformEvent;
use crate::input::image_message::ImageMessage;
use crate::input::log::topics::{Kind, Wire};
use crate::message::{bare_frame, decode_error, foxglove, ros2};

/// An image message of any of the supported types, in `frame_id` where it does not say so itself.
pub(super) fn image(kind: Kind, frame_id: Option<&str>, payload: &[u8]) -> Result<ImageMessage> {
    let mut image = match kind {
        Kind::RosImage(wire) => ImageMessage::from_ros_raw(wire.decode("sensor_msgs/Image", payload)?),
        Kind::RosCompressedImage(wire) => {
            ImageMessage::from_ros_compressed(wire.decode("sensor_msgs/CompressedImage", payload)?)
        }
        Kind::FoxgloveRawImage => ImageMessage::from_foxglove_raw(payload),
        Kind::FoxgloveCompressedImage => ImageMessage::from_foxglove_compressed(payload),
        _ => Err(decode_error("image", "the topic holds another type")),
    }?;
    if let Some(frame_id) = frame_id {
        image.frame_id = frame_id.into();
    }
    Ok(image)
}

/// A calibration message; what is wrong with its numbers is part of it.
pub(super) struct CalibrationMessage {
    pub(super) stamp_ns: u64,
    pub(super) frame_id: String,
    pub(super) calibration: Result<Calibration>,
}

pub(super) fn calibration(kind: Kind, payload: &[u8]) -> Result<CalibrationMessage> {
    match kind {
        Kind::RosCameraInfo(wire) => {
            let info: ros2::CameraInfo = wire.decode("sensor_msgs/CameraInfo", payload)?;
            let calibration = Calibration::of_ros(&info);
            let (stamp_ns, frame_id) = (info.header.stamp.stamp_ns()?, bare_frame(info.header.frame_id));
            Ok(CalibrationMessage { stamp_ns, frame_id, calibration })
        }
        Kind::FoxgloveCalibration => {
            let info: foxglove::CameraCalibration =
                foxglove::decode_protobuf("foxglove.CameraCalibration", payload)?;
            let (calibration, stamp_ns) =
                (Calibration::of_foxglove(&info), foxglove::stamp_ns(info.timestamp)?);
            Ok(CalibrationMessage { stamp_ns, frame_id: bare_frame(info.frame_id), calibration })
        }
        _ => Err(decode_error("calibration", "the topic holds another type")),
    }
}

/// The transforms of a message; `fixed` those of `/tf_static`.
pub(super) fn transforms(kind: Kind, fixed: bool, payload: &[u8]) -> Result<Vec<TransformEvent>> {
    match kind {
        Kind::RosTransforms(wire) => {
            let message: ros2::TFMessage = wire.decode("tf2_msgs/TFMessage", payload)?;
            message.transforms.into_iter().map(|transform| ros_transform(transform, fixed)).collect()
        }
        Kind::FoxgloveTransform => {
            let message = foxglove::decode_protobuf("foxglove.FrameTransform", payload)?;
            Ok(vec![foxglove_transform(message, fixed)?])
        }
        Kind::FoxgloveTransforms => {
            let message: foxglove::FrameTransforms =
                foxglove::decode_protobuf("foxglove.FrameTransforms", payload)?;
            message.transforms.into_iter().map(|transform| foxglove_transform(transform, fixed)).collect()
        }
        _ => Err(decode_error("transforms", "the topic holds another type")),
    }
}

fn ros_transform(message: ros2::TransformStamped, fixed: bool) -> Result<TransformEvent> {
    Ok(TransformEvent {
        stamp_ns: if fixed { 0 } else { message.header.stamp.stamp_ns()? },
        parent: bare_frame(message.header.frame_id),
        child: bare_frame(message.child_frame_id),
        fixed,
        parent_from_child: rigid(message.transform.translation, message.transform.rotation),
    })
}

fn foxglove_transform(message: foxglove::FrameTransform, fixed: bool) -> Result<TransformEvent> {
    let t = message.translation.unwrap_or_default();
    let parent_from_child = message.rotation.and_then(|q| Rigid::new([t.x, t.y, t.z], [q.x, q.y, q.z, q.w]));
    Ok(TransformEvent {
        stamp_ns: if fixed { 0 } else { foxglove::stamp_ns(message.timestamp)? },
        parent: bare_frame(message.parent_frame_id),
        child: bare_frame(message.child_frame_id),
        fixed,
        parent_from_child,
    })
}

/// The pose of an odometry message, as a transform.
pub(super) fn odometry(kind: Kind, payload: &[u8]) -> Result<TransformEvent> {
    let Kind::RosOdometry(wire) = kind else {
        return Err(decode_error("odometry", "the topic holds another type"));
    };
    let message: ros2::OdometryPose = wire.decode("nav_msgs/Odometry", payload)?;
    let pose = message.pose.pose;
    Ok(TransformEvent {
        stamp_ns: message.header.stamp.stamp_ns()?,
        parent: bare_frame(message.header.frame_id),
        child: bare_frame(message.child_frame_id),
        fixed: false,
        parent_from_child: rigid(pose.position, pose.orientation),
    })
}

/// A transform without frames.
pub(super) fn transform(wire: Wire, payload: &[u8]) -> Result<Rigid> {
    let message: ros2::Transform = wire.decode("geometry_msgs/Transform", payload)?;
    rigid(message.translation, message.rotation)
        .ok_or_else(|| decode_error("geometry_msgs/Transform", "it is not finite or has no rotation"))
}

fn rigid(t: ros2::Vector3, q: ros2::Quaternion) -> Option<Rigid> {
    Rigid::new([t.x, t.y, t.z], [q.x, q.y, q.z, q.w])
}
