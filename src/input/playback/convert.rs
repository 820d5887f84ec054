//! Messages of recordings as ROS 2 has them: little-endian CDR as it is; ROS 1, big-endian CDR and Foxglove's protobuf through
//! limpid's own message types.

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::base::Result;
use crate::input::points::velodyne::ScanMessage;
use crate::message::foxglove::{self, decode_protobuf, packed_element_field::NumericType};
use crate::message::lidar::{CustomMsg, LaserScan, MultiEchoLaserScan, PointCloud};
use crate::message::live::Odometry;
use crate::message::ros2::{
    CameraInfo, CompressedImage, Header, Image, PointCloud2, PointField, PoseStamped, Quaternion, TFMessage,
    Time, Transform, TransformStamped, Vector3, decode_cdr, encode_cdr,
};
use crate::message::{decode_error, ros1};

/// Encapsulation of big-endian CDR.
const BIG_ENDIAN: &[u8] = &[0, 0];

/// How a payload becomes one of ROS 2.
type Convert = fn(&str, &[u8]) -> Result<Vec<u8>>;

/// See the module.
pub(super) struct Conversion {
    type_name: String,
    /// `None`: little-endian CDR is passed on as it is.
    convert: Option<Convert>,
    /// Of CDR in the other byte order.
    swap: Option<Convert>,
    is_transforms: bool,
}

impl Conversion {
    /// For messages of an encoding (`cdr`, `ros1`, `protobuf`) and a schema; else why they cannot be played.
    pub(super) fn of(encoding: &str, schema: &str) -> Result<Self, String> {
        let ros = |schema: &str| match schema.split('/').collect::<Vec<_>>()[..] {
            [package, name] | [package, "msg", name] => Some(format!("{package}/msg/{name}")),
            _ => None,
        };
        let not_a_type = || format!("`{schema}` is not a message type");
        match encoding {
            "cdr" => {
                let type_name = ros(schema).ok_or_else(not_a_type)?;
                let swap = known(&type_name).map(|known| known.from_cdr);
                Ok(Self { type_name, convert: None, swap, is_transforms: false })
            }
            "ros1" => {
                let stated = if schema == "tf/tfMessage" { "tf2_msgs/TFMessage" } else { schema };
                let type_name = ros(stated).ok_or_else(not_a_type)?;
                let known = known(&type_name).ok_or_else(|| format!("{schema} of ROS 1 is not converted"))?;
                Ok(Self { type_name, convert: Some(known.from_ros1), swap: None, is_transforms: false })
            }
            "protobuf" => {
                let (type_name, convert) =
                    of_foxglove(schema).ok_or_else(|| format!("{schema} (protobuf) is not converted"))?;
                let is_transforms = type_name == "tf2_msgs/msg/TFMessage";
                Ok(Self { type_name: type_name.into(), convert: Some(convert), swap: None, is_transforms })
            }
            other => Err(format!("messages encoded as `{other}` are not converted")),
        }
    }

    /// Type in ROS 2, as in `sensor_msgs/msg/Image`.
    pub(super) fn type_name(&self) -> &str {
        &self.type_name
    }

    /// The topic that messages recorded on `topic` are played on: transforms of Foxglove go where ROS looks for them.
    pub(super) fn topic<'a>(&self, topic: &'a str) -> &'a str {
        match (self.is_transforms, topic.contains("static")) {
            (false, _) => topic,
            (true, true) => "/tf_static",
            (true, false) => "/tf",
        }
    }

    /// Encapsulated little-endian CDR.
    ///
    /// # Errors
    /// [`crate::Error::Decode`] for messages that are not what they are said to be.
    pub(super) fn convert(&self, payload: Vec<u8>) -> Result<Vec<u8>> {
        if let Some(convert) = self.convert {
            return convert(&self.type_name, &payload);
        }
        match (payload.get(..2), self.swap) {
            (Some([0, 1]), _) if payload.len() >= 4 => Ok(payload),
            (Some(BIG_ENDIAN), Some(swap)) => swap(&self.type_name, &payload),
            (Some(BIG_ENDIAN), None) => {
                Err(decode_error(&*self.type_name, "is big-endian and of no known type"))
            }
            _ => Err(decode_error(&*self.type_name, "does not start with a header of plain CDR")),
        }
    }
}

/// A type that limpid knows in both serialisations of ROS.
struct Known {
    from_ros1: Convert,
    from_cdr: Convert,
}

impl Known {
    fn of<T: DeserializeOwned + Serialize>() -> Self {
        Self {
            from_ros1: |what, payload| encode_cdr(what, &ros1::decode::<T>(what, payload)?),
            from_cdr: |what, payload| encode_cdr(what, &decode_cdr::<T>(what, payload)?),
        }
    }
}

fn known(type_name: &str) -> Option<Known> {
    Some(match type_name {
        "sensor_msgs/msg/Image" => Known::of::<Image>(),
        "sensor_msgs/msg/CompressedImage" => Known::of::<CompressedImage>(),
        "sensor_msgs/msg/CameraInfo" => Known::of::<CameraInfo>(),
        "sensor_msgs/msg/PointCloud2" => Known::of::<PointCloud2>(),
        "sensor_msgs/msg/PointCloud" => Known::of::<PointCloud>(),
        "sensor_msgs/msg/LaserScan" => Known::of::<LaserScan>(),
        "sensor_msgs/msg/MultiEchoLaserScan" => Known::of::<MultiEchoLaserScan>(),
        "livox_ros_driver2/msg/CustomMsg"
        | "livox_ros_driver/msg/CustomMsg"
        | "livox_interfaces/msg/CustomMsg" => Known::of::<CustomMsg>(),
        "tf2_msgs/msg/TFMessage" => Known::of::<TFMessage>(),
        "nav_msgs/msg/Odometry" => Known::of::<Odometry>(),
        "geometry_msgs/msg/PoseStamped" => Known::of::<PoseStamped>(),
        "geometry_msgs/msg/Transform" => Known::of::<Transform>(),
        "std_msgs/msg/Float32" => Known::of::<f32>(),
        "std_msgs/msg/String" => Known::of::<String>(),
        "velodyne_msgs/msg/VelodyneScan" => Known {
            from_ros1: |what, payload| packets(what, &ScanMessage::from_ros1(payload)?),
            from_cdr: |what, payload| packets(what, &ScanMessage::from_cdr(payload)?),
        },
        _ => return None,
    })
}

/// `velodyne_msgs/VelodyneScan`: a header, then packets of a stamp and 1206 bytes, each on a multiple of four.
fn packets(what: &str, message: &ScanMessage<'_>) -> Result<Vec<u8>> {
    let count =
        u32::try_from(message.packets.len()).map_err(|error| decode_error(what, error.to_string()))?;
    let mut payload = encode_cdr(what, &(Header::new(message.stamp_ns, &message.frame_id), count))?;
    for packet in &message.packets {
        payload.resize(payload.len().next_multiple_of(4), 0);
        let Time { sec, nanosec } = Time::from_stamp_ns(packet.stamp_ns);
        payload.extend(sec.to_le_bytes());
        payload.extend(nanosec.to_le_bytes());
        payload.extend_from_slice(packet.payload);
    }
    Ok(payload)
}

/// Type in ROS 2 and conversion of one of Foxglove's messages.
fn of_foxglove(schema: &str) -> Option<(&'static str, Convert)> {
    Some(match schema {
        "foxglove.RawImage" => ("sensor_msgs/msg/Image", raw_image as Convert),
        "foxglove.CompressedImage" => ("sensor_msgs/msg/CompressedImage", compressed_image),
        "foxglove.CameraCalibration" => ("sensor_msgs/msg/CameraInfo", calibration),
        "foxglove.FrameTransform" => ("tf2_msgs/msg/TFMessage", frame_transform),
        "foxglove.FrameTransforms" => ("tf2_msgs/msg/TFMessage", frame_transforms),
        "foxglove.PointCloud" => ("sensor_msgs/msg/PointCloud2", point_cloud),
        _ => return None,
    })
}

fn header(timestamp: Option<foxglove::Timestamp>, frame_id: &str) -> Result<Header> {
    Ok(Header::new(foxglove::stamp_ns(timestamp)?, frame_id))
}

fn raw_image(what: &str, payload: &[u8]) -> Result<Vec<u8>> {
    let image: foxglove::RawImage = decode_protobuf("foxglove.RawImage", payload)?;
    let header = header(image.timestamp, &image.frame_id)?;
    let foxglove::RawImage { width, height, encoding, step, data, .. } = image;
    encode_cdr(what, &Image { header, height, width, encoding, is_bigendian: 0, step, data })
}

fn compressed_image(what: &str, payload: &[u8]) -> Result<Vec<u8>> {
    let image: foxglove::CompressedImage = decode_protobuf("foxglove.CompressedImage", payload)?;
    let header = header(image.timestamp, &image.frame_id)?;
    encode_cdr(what, &CompressedImage { header, format: image.format, data: image.data })
}

fn calibration(what: &str, payload: &[u8]) -> Result<Vec<u8>> {
    let camera: foxglove::CameraCalibration = decode_protobuf("foxglove.CameraCalibration", payload)?;
    let header = header(camera.timestamp, &camera.frame_id)?;
    fn matrix<const N: usize>(name: &str, numbers: &[f64]) -> Result<[f64; N]> {
        // Foxglove leaves out what is not known, ROS fills it with zeros.
        let unstated = numbers.is_empty().then_some([0.0; N]);
        unstated.or_else(|| numbers.try_into().ok()).ok_or_else(|| {
            decode_error(
                "foxglove.CameraCalibration",
                format!("{name} has {} numbers in place of {N}", numbers.len()),
            )
        })
    }
    let info = CameraInfo {
        header,
        height: camera.height,
        width: camera.width,
        distortion_model: camera.distortion_model,
        d: camera.d,
        k: matrix("K", &camera.k)?,
        r: matrix("R", &camera.r)?,
        p: matrix("P", &camera.p)?,
        ..CameraInfo::default()
    };
    encode_cdr(what, &info)
}

fn transform(of: foxglove::FrameTransform) -> Result<TransformStamped> {
    let t = of.translation.unwrap_or_default();
    let q = of.rotation.ok_or_else(|| decode_error("foxglove.FrameTransform", "it has no rotation"))?;
    let translation = Vector3 { x: t.x, y: t.y, z: t.z };
    let rotation = Quaternion { x: q.x, y: q.y, z: q.z, w: q.w };
    Ok(TransformStamped {
        header: header(of.timestamp, &of.parent_frame_id)?,
        child_frame_id: of.child_frame_id,
        transform: Transform { translation, rotation },
    })
}

fn frame_transform(what: &str, payload: &[u8]) -> Result<Vec<u8>> {
    let one = transform(decode_protobuf("foxglove.FrameTransform", payload)?)?;
    encode_cdr(what, &TFMessage { transforms: vec![one] })
}

fn frame_transforms(what: &str, payload: &[u8]) -> Result<Vec<u8>> {
    let all: foxglove::FrameTransforms = decode_protobuf("foxglove.FrameTransforms", payload)?;
    let transforms = all.transforms.into_iter().map(transform).collect::<Result<_>>()?;
    encode_cdr(what, &TFMessage { transforms })
}

fn point_cloud(what: &str, payload: &[u8]) -> Result<Vec<u8>> {
    let cloud: foxglove::PointCloud = decode_protobuf("foxglove.PointCloud", payload)?;
    let bad = |reason: String| Err(decode_error("foxglove.PointCloud", reason));
    if cloud.pose.is_some_and(|pose| !is_identity(pose)) {
        return bad("has a pose of its own, which PointCloud2 cannot say".into());
    }
    let stride = cloud.point_stride as usize;
    if stride == 0 || !cloud.data.len().is_multiple_of(stride) {
        return bad(format!("{} bytes of data are no points of {stride} bytes", cloud.data.len()));
    }
    let fields = cloud.fields.iter().map(|field| match datatype(field.r#type()) {
        Some(datatype) => {
            Ok(PointField { name: field.name.clone(), offset: field.offset, datatype, count: 1 })
        }
        None => {
            Err(decode_error("foxglove.PointCloud", format!("field `{}` is of unknown type", field.name)))
        }
    });
    let points = u32::try_from(cloud.data.len() / stride).unwrap_or(u32::MAX);
    let message = PointCloud2 {
        header: header(cloud.timestamp, &cloud.frame_id)?,
        height: 1,
        width: points,
        fields: fields.collect::<Result<_>>()?,
        is_bigendian: 0,
        point_step: cloud.point_stride,
        row_step: points.saturating_mul(cloud.point_stride),
        data: cloud.data,
        is_dense: 0,
    };
    encode_cdr(what, &message)
}

fn is_identity(pose: foxglove::Pose) -> bool {
    let at_origin = pose.position.is_none_or(|p| p == foxglove::Vector3::default());
    at_origin && pose.orientation.is_none_or(|q| (q.x, q.y, q.z) == (0.0, 0.0, 0.0))
}

/// Code in `sensor_msgs/PointField`.
fn datatype(of: NumericType) -> Option<u8> {
    Some(match of {
        NumericType::Int8 => 1,
        NumericType::Uint8 => 2,
        NumericType::Int16 => 3,
        NumericType::Uint16 => 4,
        NumericType::Int32 => 5,
        NumericType::Uint32 => 6,
        NumericType::Float32 => 7,
        NumericType::Float64 => 8,
        NumericType::Unknown => return None,
    })
}
