//! Any bytes as the messages of a topic, of every type that is read, between a camera's sound depth images, calibrations and
//! transforms.
#![no_main]

mod read;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::{Arc, LazyLock};

use libfuzzer_sys::fuzz_target;
use limpid::message::ros2::{
    CameraInfo, Header, Image, Quaternion, TFMessage, Time, Transform, TransformStamped, encode_cdr,
};
use mcap::{Channel, Message, Schema, WriteOptions};

const FRAME: &str = "camera";

/// Topic, type and encoding of what is any bytes.
const TYPES: [[&str; 3]; 26] = [
    ["/depth/camera_info", "sensor_msgs/msg/CameraInfo", "cdr"],
    ["/depth/camera_info", "sensor_msgs/CameraInfo", "ros1"],
    ["/depth/camera_info", "foxglove.CameraCalibration", "protobuf"],
    ["/depth/image_raw", "sensor_msgs/msg/Image", "cdr"],
    ["/depth/image_raw", "sensor_msgs/Image", "ros1"],
    ["/depth/image_raw", "foxglove.RawImage", "protobuf"],
    ["/depth/image_raw/compressedDepth", "sensor_msgs/msg/CompressedImage", "cdr"],
    ["/depth/image_raw/compressedDepth", "sensor_msgs/CompressedImage", "ros1"],
    ["/depth/image_raw", "foxglove.CompressedImage", "protobuf"],
    ["/color/image_raw", "sensor_msgs/msg/Image", "cdr"],
    ["/color/image_raw/compressed", "sensor_msgs/msg/CompressedImage", "cdr"],
    ["/tf", "tf2_msgs/msg/TFMessage", "cdr"],
    ["/tf_static", "tf2_msgs/TFMessage", "ros1"],
    ["/tf", "foxglove.FrameTransform", "protobuf"],
    ["/tf", "foxglove.FrameTransforms", "protobuf"],
    ["/odom", "nav_msgs/msg/Odometry", "cdr"],
    ["/points", "sensor_msgs/msg/PointCloud2", "cdr"],
    ["/points", "sensor_msgs/PointCloud2", "ros1"],
    ["/points", "foxglove.PointCloud", "protobuf"],
    ["/points", "sensor_msgs/msg/PointCloud", "cdr"],
    ["/points", "velodyne_msgs/msg/VelodyneScan", "cdr"],
    ["/points", "livox_ros_driver2/msg/CustomMsg", "cdr"],
    ["/scan", "sensor_msgs/msg/LaserScan", "cdr"],
    ["/scan", "sensor_msgs/msg/MultiEchoLaserScan", "cdr"],
    ["/scan", "foxglove.LaserScan", "protobuf"],
    ["/goal_pose", "geometry_msgs/msg/PoseStamped", "cdr"],
];

fn header(sec: i32) -> Header {
    Header { stamp: Time { sec, nanosec: 0 }, frame_id: FRAME.into() }
}

/// Topic, type and payload of a sound message of each kind.
static SOUND: LazyLock<Vec<[Vec<u8>; 3]>> = LazyLock::new(|| {
    let sound = |sec: i32| {
        let image = Image {
            header: header(sec),
            height: 3,
            width: 4,
            encoding: "16UC1".into(),
            is_bigendian: 0,
            step: 8,
            data: vec![3; 24],
        };
        let info = CameraInfo {
            header: header(sec),
            height: 3,
            width: 4,
            k: [4.0, 0.0, 1.5, 0.0, 4.0, 1.0, 0.0, 0.0, 1.0],
            ..CameraInfo::default()
        };
        let rotation = Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 };
        let transform = TransformStamped {
            header: Header { frame_id: "map".into(), ..header(sec) },
            child_frame_id: FRAME.into(),
            transform: Transform { rotation, ..Transform::default() },
        };
        [
            encode_cdr("CameraInfo", &info),
            encode_cdr("TFMessage", &TFMessage { transforms: vec![transform] }),
            encode_cdr("Image", &image),
        ]
        .map(|payload| payload.expect("a sound message"))
    };
    (1..4).map(sound).collect()
});

const SOUND_TYPES: [[&str; 3]; 3] = [
    ["/depth/camera_info", "sensor_msgs/msg/CameraInfo", "cdr"],
    ["/tf", "tf2_msgs/msg/TFMessage", "cdr"],
    ["/depth/image_raw", "sensor_msgs/msg/Image", "cdr"],
];

fn channel(id: u16, [topic, name, message_encoding]: [&str; 3]) -> Arc<Channel<'static>> {
    let schema = Schema { id: id + 1, name: name.into(), encoding: String::new(), data: Cow::Borrowed(&[]) };
    Arc::new(Channel {
        id,
        topic: topic.into(),
        schema: Some(Arc::new(schema)),
        message_encoding: message_encoding.into(),
        metadata: BTreeMap::new(),
    })
}

fn recording(any: [&str; 3], payloads: &[&[u8]]) -> mcap::McapResult<Vec<u8>> {
    let mut file = Cursor::new(Vec::new());
    let options = WriteOptions::new().use_chunks(false).compression(None);
    let mut writer = options.create(&mut file)?;
    let any_channel = channel(3, any);
    let mut write = |channel: &Arc<Channel<'static>>, log_time: u64, data: &[u8]| {
        let data = Cow::Owned(data.to_vec());
        writer.write(&Message { channel: channel.clone(), sequence: 0, log_time, publish_time: log_time, data })
    };
    for (second, sound) in (1..).zip(SOUND.iter()) {
        for (id, (about, payload)) in (0..).zip(SOUND_TYPES.iter().zip(sound)) {
            // What is any bytes takes the place of what is sound.
            if about[0] != any[0] {
                write(&channel(id, *about), second * 1_000_000_000, payload)?;
            }
        }
        for payload in payloads {
            write(&any_channel, second * 1_000_000_000 + 1, payload)?;
        }
    }
    writer.finish()?;
    drop(writer);
    Ok(file.into_inner())
}

fuzz_target!(|bytes: &[u8]| {
    let [kind, split, bytes @ ..] = bytes else { return };
    // One message or two.
    let (first, second) = bytes.split_at(bytes.len().min(4 * usize::from(*split)));
    let payloads = if first.is_empty() { vec![second] } else { vec![first, second] };
    let Ok(file) = recording(TYPES[usize::from(*kind) % TYPES.len()], &payloads) else { return };
    read::read_all(&read::written("input.mcap", &file), file.len());
});
