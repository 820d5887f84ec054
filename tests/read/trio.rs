//! Recordings of a robot with two cameras and a lidar.

use limpid::Config;
use limpid::config::{SensorConfig, SensorKind};
use limpid::message::ros2::{PointCloud2, PointField, TFMessage};

use super::synthetic::{Recorder, Saved, at_ms, camera_info, depth_image, header, raw_image, transform};

const NO_ROTATION: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

/// Messages of two cameras, a lidar and the base, to be written in order of the times they are logged at.
#[derive(Default)]
pub(super) struct Drive {
    pub(super) messages: Vec<(u64, Message)>,
}

pub(super) enum Message {
    /// Of a camera: its name and stamp.
    Depth(&'static str, u64),
    Color(&'static str, u64),
    Scan(u64),
    /// The base is at x = seconds of the stamp.
    Base(u64),
}

impl Drive {
    /// `seconds` of a drive: cameras at 30 and 20 Hz, a lidar at 10 Hz that is logged after its revolution, odometry.
    pub(super) fn of(seconds: u64) -> Self {
        let mut drive = Self::default();
        for i in 0..30 * seconds {
            drive.at(33 * i + 20, Message::Depth("front", 33 * i));
            drive.at(33 * i + 12, Message::Color("front", 33 * i));
        }
        for i in 0..20 * seconds {
            drive.at(50 * i + 8, Message::Depth("rear", 50 * i));
        }
        for i in 0..10 * seconds {
            drive.at(100 * i + 105, Message::Scan(100 * i));
        }
        for i in 0..=50 * seconds + 10 {
            drive.at(20 * i + 3, Message::Base(20 * i));
        }
        drive
    }

    pub(super) fn at(&mut self, log_ms: u64, message: Message) {
        self.messages.push((log_ms, message));
    }

    /// With the stamps of some messages changed.
    pub(super) fn restamped(mut self, change: impl Fn(u64, &mut Message)) -> Self {
        self.messages.iter_mut().for_each(|(log_ms, message)| change(*log_ms, message));
        self
    }

    pub(super) fn save(mut self, frames: &[&str]) -> Saved {
        self.messages.sort_by_key(|(log_ms, _)| *log_ms);
        let mut recorder = Recorder::new();
        for frame in frames {
            recorder.transform("/tf_static", at_ms(0), ["base_link", frame], [0.1, 0.0, 1.0], NO_ROTATION);
        }
        for (log_ms, message) in self.messages {
            write(&mut recorder, at_ms(log_ms), &message);
        }
        recorder.save()
    }
}

pub(super) fn write(recorder: &mut Recorder, log_ns: u64, message: &Message) {
    match *message {
        Message::Depth(name, ms) => {
            let frame = format!("{name}_optical");
            recorder.info(&format!("/{name}/depth/camera_info"), log_ns, &camera_info(at_ms(ms), &frame));
            let mut image = depth_image(at_ms(ms), 900);
            image.header.frame_id = frame;
            recorder.image(&format!("/{name}/depth/image_raw"), log_ns, &image);
        }
        Message::Color(name, ms) => {
            let mut image = raw_image(at_ms(ms), "rgb8", 12, vec![5; 36]);
            image.header.frame_id = format!("{name}_optical");
            recorder.image(&format!("/{name}/color/image_raw"), log_ns, &image);
        }
        Message::Scan(ms) => {
            recorder.ros("/points", "sensor_msgs/msg/PointCloud2", log_ns, &cloud(at_ms(ms)));
        }
        Message::Base(ms) => {
            let base = transform(at_ms(ms), ["map", "base_link"], [ms as f64 * 1e-3, 0.0, 0.0], NO_ROTATION);
            let message = TFMessage { transforms: vec![base] };
            recorder.ros("/tf", "tf2_msgs/msg/TFMessage", log_ns, &message);
        }
    }
}

pub(super) fn cloud(stamp_ns: u64) -> PointCloud2 {
    let field =
        |(at, name): (u32, &str)| PointField { name: name.into(), offset: 4 * at, datatype: 7, count: 1 };
    PointCloud2 {
        header: header(stamp_ns, "lidar"),
        height: 1,
        width: 2,
        fields: (0..).zip(["x", "y", "z", "intensity"]).map(field).collect(),
        is_bigendian: 0,
        point_step: 16,
        row_step: 32,
        data: [2.0_f32, 0.0, 0.1, 200.0, 3.0, 1.0, 0.2, 100.0]
            .into_iter()
            .flat_map(f32::to_le_bytes)
            .collect(),
        is_dense: 1,
    }
}

pub(super) const ALL_FRAMES: [&str; 3] = ["front_optical", "rear_optical", "lidar"];

pub(super) fn camera(name: &str) -> SensorConfig {
    let parameters = Config { depth_topic: format!("/{name}/depth/image_raw"), ..Config::default() };
    SensorConfig { name: name.into(), kind: SensorKind::Camera, timeout_s: 0.5, parameters }
}

pub(super) fn lidar(topic: &str) -> SensorConfig {
    let parameters = Config { scan_topic: topic.into(), ..Config::default() };
    SensorConfig { name: "top".into(), kind: SensorKind::Lidar, timeout_s: 0.3, parameters }
}

pub(super) fn three() -> Config {
    Config { sensors: vec![camera("front"), camera("rear"), lidar("/points")], ..Config::default() }
}
