//! Messages made of the images and scans of recordings that hold none: TUM folders, still pairs, lidar files.

use std::collections::VecDeque;

use serde::Serialize;

use crate::base::{Result, Rigid};
use crate::config::SensorInfo;
use crate::input::playback::{Played, PlayedTopic};
use crate::input::{ReadReport, Source};
use crate::message::RosMessage;
use crate::message::ros2::{
    CameraInfo, Header, Image, PointCloud2, PointField, TFMessage, TransformStamped, encode_cdr,
};
use crate::sensor::{DepthSamples, Observation, RgbdFrame, Scan, SensorData, SensorModel};

/// Millimetres, the unit that ROS gives integer depth.
const MILLIMETRE: f64 = 0.001;

/// Frames of sensors that have none of their own.
const CAMERA_FRAME: &str = "camera_optical_frame";
const LIDAR_FRAME: &str = "lidar";

/// `sensor_msgs/PointField`'s codes.
const UINT8: u8 = 2;
const UINT16: u8 = 4;
const FLOAT32: u8 = 7;

/// Name, code, offset of what a point holds; 24 bytes a point.
const FIELDS: [(&str, u8, u32); 8] = [
    ("x", FLOAT32, 0),
    ("y", FLOAT32, 4),
    ("z", FLOAT32, 8),
    ("intensity", FLOAT32, 12),
    ("time", FLOAT32, 16),
    ("ring", UINT16, 20),
    ("return_type", UINT8, 22),
    ("strength", UINT8, 23),
];
const POINT_STEP: u32 = 24;

/// See the module.
pub(super) struct MadeMessages {
    source: Box<dyn Source>,
    base_frame: String,
    pub(super) topics: Vec<PlayedTopic>,
    ready: VecDeque<Played>,
}

impl MadeMessages {
    pub(super) fn new(source: Box<dyn Source>) -> Self {
        let sensor = source.sensors().iter().find(|sensor| !matches!(sensor.model, SensorModel::Missing(_)));
        let base_frame =
            sensor.map_or_else(|| "base_link".into(), |sensor: &SensorInfo| sensor.config.base_frame.clone());
        Self { source, base_frame, topics: Vec::new(), ready: VecDeque::new() }.with_topics()
    }

    /// All topics that there can be, so that others find them before the first message.
    fn with_topics(mut self) -> Self {
        let camera =
            self.source.sensors().iter().any(|sensor| matches!(sensor.model, SensorModel::Camera(_)));
        let colored = self.source.sensors().iter().any(|sensor| match &sensor.model {
            SensorModel::Camera(camera) => camera.color.is_some(),
            _ => false,
        });
        let mut add = |name: &str, type_name: &str| self.topics.push(PlayedTopic::new(name, type_name));
        if camera {
            add("/camera/depth/image_raw", Image::TYPE);
            add("/camera/depth/camera_info", CameraInfo::TYPE);
        } else {
            add("/points", PointCloud2::TYPE);
        }
        if colored {
            add("/camera/color/image_raw", Image::TYPE);
            add("/camera/color/camera_info", CameraInfo::TYPE);
        }
        add("/tf", TFMessage::TYPE);
        self
    }

    pub(super) fn report(&self) -> ReadReport {
        self.source.report().read
    }

    pub(super) fn next_message(&mut self) -> Result<Option<Played>> {
        loop {
            if let Some(ready) = self.ready.pop_front() {
                return Ok(Some(ready));
            }
            let Some(observation) = self.source.next()? else { return Ok(None) };
            match &observation.data {
                SensorData::Frame(frame) => self.make_frame(&observation, frame)?,
                SensorData::Scan(scan) => self.make_scan(&observation, scan)?,
            }
        }
    }

    fn put<M: RosMessage + Serialize>(&mut self, topic: &str, at_ns: u64, message: &M) -> Result<()> {
        let payload = encode_cdr(M::TYPE, message)?;
        if let Some(topic) = self.topics.iter().position(|other| other.name == topic) {
            self.ready.push_back(Played { topic, at_ns, payload });
        }
        Ok(())
    }

    /// Transforms first, so that an image that comes has its pose.
    fn make_transforms(
        &mut self,
        observation: &Observation,
        sensor_frame: &str,
        more: Option<TransformStamped>,
    ) -> Result<()> {
        let stamp_ns = observation.stamp_ns();
        let edge = |parent: &str, child: &str, parent_from_child: Rigid| TransformStamped {
            header: Header::new(stamp_ns, parent),
            child_frame_id: child.into(),
            transform: parent_from_child.into(),
        };
        let mut transforms = Vec::new();
        // A map that is the sensor's own frame needs none.
        if let Some(pose) = observation.pose.filter(|_| observation.map_frame != sensor_frame) {
            transforms.push(edge(&observation.map_frame, &self.base_frame, pose.map_from_base));
            if sensor_frame != self.base_frame {
                transforms.push(edge(&self.base_frame, sensor_frame, pose.base_from_sensor));
            }
        }
        transforms.extend(more);
        if transforms.is_empty() {
            return Ok(());
        }
        self.put("/tf", stamp_ns, &TFMessage { transforms })
    }

    fn make_frame(&mut self, observation: &Observation, frame: &RgbdFrame) -> Result<()> {
        let (depth, stamp_ns) = (&frame.depth, frame.depth.stamp_ns);
        let depth_frame = named(&depth.frame_id, CAMERA_FRAME);
        let apart = frame.color_from_depth.filter(|&color_from_depth| color_from_depth != Rigid::IDENTITY);
        let color_frame = if apart.is_some() { format!("{depth_frame}_color") } else { depth_frame.clone() };
        let more = apart.map(|color_from_depth| TransformStamped {
            header: Header::new(stamp_ns, &depth_frame),
            child_frame_id: color_frame.clone(),
            transform: color_from_depth.inverse().into(),
        });
        self.make_transforms(observation, &depth_frame, more)?;
        let header = Header::new(stamp_ns, &depth_frame);
        self.put("/camera/depth/camera_info", stamp_ns, &CameraInfo::new(header.clone(), &depth.camera))?;
        if let Some(color) = &frame.color {
            let header = Header::new(color.stamp_ns, &color_frame);
            let size = (color.camera.width, color.camera.height);
            let info = CameraInfo::new(header.clone(), &color.camera);
            self.put("/camera/color/camera_info", stamp_ns, &info)?;
            let message = image(header, size, ("rgb8", 3), color.rgb.clone());
            self.put("/camera/color/image_raw", stamp_ns, &message)?;
        }
        let (encoding, data) = depth_bytes(&depth.samples);
        let size = (depth.camera.width, depth.camera.height);
        self.put("/camera/depth/image_raw", stamp_ns, &image(header, size, encoding, data))
    }

    fn make_scan(&mut self, observation: &Observation, scan: &Scan) -> Result<()> {
        let frame = named(&scan.frame_id, LIDAR_FRAME);
        self.make_transforms(observation, &frame, None)?;
        self.put("/points", scan.stamp_ns, &cloud(Header::new(scan.stamp_ns, &frame), scan))
    }
}

fn named(frame_id: &str, otherwise: &str) -> String {
    if frame_id.is_empty() { otherwise.into() } else { frame_id.into() }
}

fn image(
    header: Header,
    (width, height): (u32, u32),
    (encoding, bytes): (&str, u32),
    data: Vec<u8>,
) -> Image {
    Image { header, height, width, encoding: encoding.into(), is_bigendian: 0, step: width * bytes, data }
}

/// Encoding with its bytes a pixel, and the samples: integers of millimetres as they are, others in metres.
fn depth_bytes(samples: &DepthSamples) -> ((&'static str, u32), Vec<u8>) {
    let metres = |values: &mut dyn Iterator<Item = f32>| values.flat_map(f32::to_le_bytes).collect();
    match samples {
        DepthSamples::Integer { raw, unit_m } if *unit_m == MILLIMETRE => {
            (("16UC1", 2), raw.iter().flat_map(|count| count.to_le_bytes()).collect())
        }
        DepthSamples::Integer { raw, unit_m } => {
            let mut in_metres = raw.iter().map(|&count| match count {
                u16::MAX => 0.0,
                count => crate::base::single(f64::from(count) * unit_m),
            });
            (("32FC1", 4), metres(&mut in_metres))
        }
        DepthSamples::Metres(in_metres) => (("32FC1", 4), metres(&mut in_metres.iter().copied())),
    }
}

fn cloud(header: Header, scan: &Scan) -> PointCloud2 {
    let mut data = Vec::with_capacity(scan.points.len() * POINT_STEP as usize);
    for point in &scan.points {
        for value in [point.x_m, point.y_m, point.z_m, point.intensity, point.time_s] {
            data.extend(value.to_le_bytes());
        }
        data.extend(point.ring.to_le_bytes());
        data.extend([point.return_type as u8, point.strength as u8]);
    }
    let has = |name: &str| match name {
        "time" => scan.columns.time,
        "ring" => scan.columns.ring,
        "return_type" | "strength" => scan.columns.return_type,
        _ => true,
    };
    let fields = FIELDS.iter().filter(|(name, ..)| has(name));
    let fields =
        fields.map(|&(name, datatype, offset)| PointField { name: name.into(), offset, datatype, count: 1 });
    let width = u32::try_from(scan.points.len()).unwrap_or(u32::MAX);
    PointCloud2 {
        header,
        height: 1,
        width,
        fields: fields.collect(),
        is_bigendian: 0,
        point_step: POINT_STEP,
        row_step: width.saturating_mul(POINT_STEP),
        data,
        is_dense: 1,
    }
}
