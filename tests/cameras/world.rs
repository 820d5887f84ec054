//! Small recordings of one scene, each with something else amiss.

use glam::DVec3;
use limpid::base::Rigid;
use limpid::message::ros2::{CameraInfo, Image};
use limpid::sensor::CameraModel;

use crate::read::synthetic::{Recorder, Saved, at_ms, header, transform};
use crate::support::scene::{Block, Scene, pose, small_camera};

/// Milliseconds of the depth images.
pub(crate) const TIMES_MS: [u64; 10] = [0, 50, 100, 150, 200, 250, 300, 350, 400, 450];

/// A wall, and a box before it.
fn scene() -> Scene {
    Scene::of(&[
        Block::new([3.01, -3.0, 0.0], [3.2, 3.0, 2.5]),
        Block::new([1.53, -0.31, 0.0], [1.73, 0.29, 0.6]),
    ])
}

/// What a recording is of.
#[derive(Clone)]
pub(crate) struct Take {
    pub(crate) camera: CameraModel,
    pub(crate) depth_topic: &'static str,
    pub(crate) color_topic: &'static str,
    pub(crate) depth_frame: &'static str,
    pub(crate) color_frame: &'static str,
    /// Milliseconds of the colour images.
    pub(crate) color_ms: Vec<u64>,
    /// Of depth and colour; `None`: no such topics.
    pub(crate) info: Option<CameraInfo>,
    /// Counts to the metre.
    pub(crate) per_metre: f64,
    /// Depth as floats, in units of which so many make a metre, in place of counts.
    pub(crate) floats: bool,
    /// Whether the camera is turned around.
    pub(crate) back: bool,
}

impl Default for Take {
    fn default() -> Self {
        let camera = small_camera();
        Self {
            camera,
            depth_topic: "/cam/depth/image_raw",
            color_topic: "/cam/color/image_raw",
            depth_frame: "cam_optical",
            color_frame: "cam_optical",
            color_ms: TIMES_MS.to_vec(),
            info: Some(CameraInfo::new(header(at_ms(0), ""), &camera)),
            per_metre: 1000.0,
            floats: false,
            back: false,
        }
    }
}

impl Take {
    /// Where base and camera are: 0.6 m high, pitched down a little.
    fn base_from_camera(&self) -> Rigid {
        let ahead = pose(0.0, 0.0, 0.0, 0.6, 0.2).base_from_camera;
        let turn = glam::DQuat::from_rotation_z(if self.back { std::f64::consts::PI } else { 0.0 });
        Rigid { rotation: turn * ahead.rotation, ..ahead }
    }

    fn map_from_base() -> Rigid {
        Rigid { translation_m: DVec3::new(0.013, 0.021, 0.0), ..Rigid::IDENTITY }
    }

    pub(crate) fn depth(&self, ms: u64) -> Image {
        let map_from_camera = Self::map_from_base().then(self.base_from_camera());
        let depth_m = scene().depth(&self.camera, map_from_camera).into_iter().map(f64::from);
        let data = match self.floats {
            true => depth_m.flat_map(|m| ((m * self.per_metre) as f32).to_le_bytes()).collect(),
            false => depth_m.flat_map(|m| ((m * self.per_metre).round() as u16).to_le_bytes()).collect(),
        };
        let (width, height) = (self.camera.width, self.camera.height);
        let (encoding, bytes) = if self.floats { ("32FC1", 4) } else { ("16UC1", 2) };
        let header = header(at_ms(ms), self.depth_frame);
        Image { header, height, width, encoding: encoding.into(), is_bigendian: 0, step: bytes * width, data }
    }

    fn color(&self, ms: u64) -> Image {
        let (width, height) = (self.camera.width, self.camera.height);
        let data = (0..3 * width * height).map(|i| (80 + i % 7) as u8).collect();
        let (header, encoding) = (header(at_ms(ms), self.color_frame), "rgb8".into());
        Image { header, height, width, encoding, is_bigendian: 0, step: 3 * width, data }
    }

    fn calibrate(&self, recorder: &mut Recorder, image_topic: &str, frame: &str, ms: u64) {
        let Some(info) = &self.info else { return };
        let topic = format!("{}/camera_info", image_topic.rsplit_once('/').unwrap().0);
        let info = CameraInfo { header: header(at_ms(ms), frame), ..info.clone() };
        recorder.info(&topic, at_ms(ms), &info);
    }

    /// Writes depth, colour and calibrations, and the transforms of the depth camera.
    pub(crate) fn record(&self, recorder: &mut Recorder) {
        self.place(recorder);
        let all: std::collections::BTreeSet<u64> =
            TIMES_MS.into_iter().chain(self.color_ms.clone()).collect();
        for ms in all {
            if self.color_ms.contains(&ms) {
                self.calibrate(recorder, self.color_topic, self.color_frame, ms);
                recorder.image(self.color_topic, at_ms(ms), &self.color(ms));
            }
            if TIMES_MS.contains(&ms) {
                self.calibrate(recorder, self.depth_topic, self.depth_frame, ms);
                recorder.image(self.depth_topic, at_ms(ms), &self.depth(ms));
            }
        }
    }

    /// Writes the transforms, for all of the recording's time.
    pub(crate) fn place(&self, recorder: &mut Recorder) {
        let write = |recorder: &mut Recorder, topic: &str, ms: u64, frames: [&str; 2], rigid: Rigid| {
            let rotation = [rigid.rotation.x, rigid.rotation.y, rigid.rotation.z, rigid.rotation.w];
            let message = limpid::message::ros2::TFMessage {
                transforms: vec![transform(at_ms(ms), frames, rigid.translation_m.to_array(), rotation)],
            };
            recorder.ros(topic, "tf2_msgs/msg/TFMessage", at_ms(ms), &message);
        };
        write(recorder, "/tf_static", 0, ["base_link", self.depth_frame], self.base_from_camera());
        for ms in [0, 600] {
            write(recorder, "/tf", ms, ["map", "base_link"], Self::map_from_base());
        }
    }

    pub(crate) fn save(&self) -> Saved {
        let mut recorder = Recorder::new();
        self.record(&mut recorder);
        recorder.save()
    }
}
