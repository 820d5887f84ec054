//! Recordings made by the tests themselves, with the mcap crate's writer.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::PathBuf;

use limpid::message::ros2;
use limpid::message::ros2::{
    CameraInfo, CompressedImage, Header, Image, Quaternion, TFMessage, Transform, TransformStamped, Vector3,
};
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use prost::Message;

pub(crate) const DEPTH: &str = "/cam/depth/image_raw";
pub(crate) const DEPTH_INFO: &str = "/cam/depth/camera_info";
pub(crate) const COLOR: &str = "/cam/color/image_raw";
pub(crate) const COLOR_INFO: &str = "/cam/color/camera_info";
pub(crate) const FRAME: &str = "cam_optical";

/// Width and height of the synthetic images, pixels.
pub(crate) const SIZE: [u32; 2] = [4, 3];

/// A whole second plus so many milliseconds.
pub(crate) fn at_ms(ms: u64) -> u64 {
    1_000_000_000_000 + ms * 1_000_000
}

/// An MCAP file in the making.
pub(crate) struct Recorder {
    writer: Writer<Cursor<Vec<u8>>>,
    channels: BTreeMap<String, u16>,
    sequence: u32,
}

impl Recorder {
    pub(crate) fn new() -> Self {
        Self::with(WriteOptions::new().compression(None))
    }

    pub(crate) fn compressed(compression: Option<Compression>) -> Self {
        Self::with(WriteOptions::new().compression(compression).chunk_size(Some(256)))
    }

    pub(crate) fn with(options: WriteOptions) -> Self {
        let writer = options.create(Cursor::new(Vec::new())).unwrap();
        Self { writer, channels: BTreeMap::new(), sequence: 0 }
    }

    /// Adds a channel, once.
    pub(crate) fn channel(&mut self, topic: &str, schema: &str, encoding: &str) -> u16 {
        if let Some(&id) = self.channels.get(topic) {
            return id;
        }
        let schema_encoding = if encoding == "cdr" { "ros2msg" } else { encoding };
        let schema = self.writer.add_schema(schema, schema_encoding, b"").unwrap();
        let id = self.writer.add_channel(schema, topic, encoding, &BTreeMap::new()).unwrap();
        self.channels.insert(topic.into(), id);
        id
    }

    pub(crate) fn bytes(&mut self, topic: &str, schema: &str, encoding: &str, stamp_ns: u64, data: &[u8]) {
        let channel_id = self.channel(topic, schema, encoding);
        self.sequence += 1;
        let header =
            MessageHeader { channel_id, sequence: self.sequence, log_time: stamp_ns, publish_time: stamp_ns };
        self.writer.write_to_known_channel(&header, data).unwrap();
    }

    pub(crate) fn ros<T: serde::Serialize>(&mut self, topic: &str, schema: &str, stamp_ns: u64, message: &T) {
        self.bytes(topic, schema, "cdr", stamp_ns, &ros2::encode_cdr(schema, message).unwrap());
    }

    pub(crate) fn foxglove<T: Message>(&mut self, topic: &str, schema: &str, stamp_ns: u64, message: &T) {
        self.bytes(topic, schema, "protobuf", stamp_ns, &message.encode_to_vec());
    }

    pub(crate) fn image(&mut self, topic: &str, stamp_ns: u64, image: &Image) {
        self.ros(topic, "sensor_msgs/msg/Image", stamp_ns, image);
    }

    pub(crate) fn compressed_image(&mut self, topic: &str, stamp_ns: u64, format: &str, data: Vec<u8>) {
        let message = CompressedImage { header: header(stamp_ns, FRAME), format: format.into(), data };
        self.ros(topic, "sensor_msgs/msg/CompressedImage", stamp_ns, &message);
    }

    pub(crate) fn info(&mut self, topic: &str, stamp_ns: u64, info: &CameraInfo) {
        self.ros(topic, "sensor_msgs/msg/CameraInfo", stamp_ns, info);
    }

    /// A depth image whose samples are `value` mm, after its calibration.
    pub(crate) fn depth(&mut self, stamp_ns: u64, value: u16) {
        self.info(DEPTH_INFO, stamp_ns, &camera_info(stamp_ns, FRAME));
        self.image(DEPTH, stamp_ns, &depth_image(stamp_ns, value));
    }

    /// A colour image whose bytes are `value`, after its calibration.
    pub(crate) fn color(&mut self, stamp_ns: u64, value: u8) {
        self.info(COLOR_INFO, stamp_ns, &camera_info(stamp_ns, FRAME));
        let [width, height] = SIZE;
        let data = vec![value; (3 * width * height) as usize];
        let image = raw_image(stamp_ns, "rgb8", 3 * width, data);
        self.image(COLOR, stamp_ns, &image);
    }

    pub(crate) fn transform(
        &mut self,
        topic: &str,
        stamp_ns: u64,
        frames: [&str; 2],
        translation: [f64; 3],
        rotation: [f64; 4],
    ) {
        let message = TFMessage { transforms: vec![transform(stamp_ns, frames, translation, rotation)] };
        self.ros(topic, "tf2_msgs/msg/TFMessage", stamp_ns, &message);
    }

    pub(crate) fn finish(mut self) -> Vec<u8> {
        self.writer.finish().unwrap();
        self.writer.into_inner().into_inner()
    }

    /// The file on disk, which lives as long as the folder does.
    pub(crate) fn save(self) -> Saved {
        save(&self.finish())
    }
}

/// A file in a folder of its own.
pub(crate) struct Saved {
    pub(crate) path: PathBuf,
    _folder: tempfile::TempDir,
}

pub(crate) fn save(bytes: &[u8]) -> Saved {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("recording.mcap");
    std::fs::write(&path, bytes).unwrap();
    Saved { path, _folder: folder }
}

pub(crate) fn header(stamp_ns: u64, frame: &str) -> Header {
    Header::new(stamp_ns, frame)
}

pub(crate) fn raw_image(stamp_ns: u64, encoding: &str, step: u32, data: Vec<u8>) -> Image {
    let [width, height] = SIZE;
    let header = header(stamp_ns, FRAME);
    Image { header, height, width, encoding: encoding.into(), is_bigendian: 0, step, data }
}

pub(crate) fn depth_image(stamp_ns: u64, value: u16) -> Image {
    let [width, height] = SIZE;
    raw_image(stamp_ns, "16UC1", 2 * width, value.to_le_bytes().repeat((width * height) as usize))
}

pub(crate) fn camera_info(stamp_ns: u64, frame: &str) -> CameraInfo {
    let [width, height] = SIZE;
    CameraInfo {
        header: header(stamp_ns, frame),
        width,
        height,
        distortion_model: "plumb_bob".into(),
        d: vec![0.0; 5],
        k: [5.0, 0.0, 2.0, 0.0, 6.0, 1.5, 0.0, 0.0, 1.0],
        ..CameraInfo::default()
    }
}

pub(crate) fn transform(
    stamp_ns: u64,
    [parent, child]: [&str; 2],
    [x, y, z]: [f64; 3],
    [qx, qy, qz, qw]: [f64; 4],
) -> TransformStamped {
    TransformStamped {
        header: header(stamp_ns, parent),
        child_frame_id: child.into(),
        transform: Transform {
            translation: Vector3 { x, y, z },
            rotation: Quaternion { x: qx, y: qy, z: qz, w: qw },
        },
    }
}
