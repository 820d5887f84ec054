//! A robot for tests: a depth camera in front of a wall, with transforms, whose faults a test turns on and off.

use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use limpid::Config;
use limpid::config::GroundSource;
use limpid::message::live::Clock;
use limpid::message::ros2::{
    CameraInfo, Header, Image, Quaternion, TFMessage, Time, Transform, TransformStamped, Vector3, encode_cdr,
};
use limpid::ros2::{Environment, Participant, Publication, Quality};
use limpid::sensor::{CameraModel, Distortion};
use serde::Serialize;

use super::node::config;

/// How far away the wall is, metres.
const WALL_M: f32 = 2.0;

pub(super) const DEPTH: &str = "/eye/depth/image_raw";
const INFO: &str = "/eye/depth/camera_info";

/// What the robot does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Script {
    pub(super) frames: bool,
    pub(super) transforms: bool,
    /// Where the base is in the map.
    pub(super) x_m: f64,
    /// Whether somebody says that the map lies in the camera.
    pub(super) circle: bool,
    /// What is added to all stamps.
    pub(super) stamps_off_s: i64,
    pub(super) size: (u32, u32),
    pub(super) focal_px: f64,
    /// Whether `/clock` goes on, where there is one.
    pub(super) clock: bool,
    /// Frames a second.
    pub(super) rate_hz: f64,
}

impl Default for Script {
    fn default() -> Self {
        Self {
            frames: true,
            transforms: true,
            x_m: 0.0,
            circle: false,
            stamps_off_s: 0,
            size: (64, 48),
            focal_px: 50.0,
            clock: true,
            rate_hz: 20.0,
        }
    }
}

/// See the module. It runs until it is dropped.
pub(super) struct Robot {
    script: Arc<Mutex<Option<Script>>>,
    thread: Option<JoinHandle<()>>,
}

impl Robot {
    pub(super) fn start(environment: &Environment, script: Script, simulates_time: bool) -> Self {
        let shared = Arc::new(Mutex::new(Some(script)));
        let (own, environment) = (Arc::clone(&shared), environment.clone());
        let thread = std::thread::spawn(move || run(&environment, &own, simulates_time));
        Self { script: shared, thread: Some(thread) }
    }

    /// Changes what it does.
    pub(super) fn does(&self, change: impl FnOnce(&mut Script)) {
        if let Some(script) = self.script.lock().unwrap().as_mut() {
            change(script);
        }
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        *self.script.lock().unwrap() = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Parameters for it: a small map, so that a machine without a GPU keeps up.
pub(super) fn eye() -> Config {
    Config {
        depth_topic: DEPTH.into(),
        map_size_m: 6.0,
        resolution_m: 0.1,
        ground: GroundSource::Stated,
        wait_s: 0.2,
        timeout_s: 1.0,
        ..config()
    }
}

fn run(environment: &Environment, script: &Mutex<Option<Script>>, simulates_time: bool) {
    let participant = Participant::join(environment).unwrap();
    let publish = |name: &str, kind: &str, quality| participant.publish(name, kind, quality).unwrap();
    let stream = Quality::Stream { depth: 10 };
    let depth = publish(DEPTH, "sensor_msgs/msg/Image", stream);
    let info = publish(INFO, "sensor_msgs/msg/CameraInfo", stream);
    let tf = publish("/tf", "tf2_msgs/msg/TFMessage", stream);
    let clock = simulates_time.then(|| publish("/clock", "rosgraph_msgs/msg/Clock", stream));
    let mut next = Instant::now();
    loop {
        let Some(now) = *script.lock().unwrap() else { return };
        let machine = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
        let stamp_ns = (machine.as_nanos() as u64).wrapping_add_signed(now.stamps_off_s * 1_000_000_000);
        if let Some(clock) = clock.as_ref().filter(|_| now.clock) {
            send(clock, &Clock { clock: Time::from_stamp_ns(stamp_ns) });
        }
        if now.frames {
            let camera = model(&now);
            let header = Header::new(stamp_ns, "eye");
            send(&info, &CameraInfo::new(header.clone(), &camera));
            send(&depth, &wall(header, &camera));
        }
        // Where the robot was at an image is often known a little later.
        if now.transforms {
            send(&tf, &TFMessage { transforms: transforms(&now, stamp_ns) });
        }
        next += Duration::from_secs_f64(1.0 / now.rate_hz);
        std::thread::sleep(next.saturating_duration_since(Instant::now()));
    }
}

fn send<T: Serialize>(to: &Publication, message: &T) {
    to.send(encode_cdr("message", message).unwrap()).unwrap();
}

fn model(of: &Script) -> CameraModel {
    let ((width, height), f) = (of.size, of.focal_px);
    let centre = |pixels: u32| f64::from(pixels) / 2.0;
    CameraModel {
        width,
        height,
        fx: f,
        fy: f,
        cx: centre(width),
        cy: centre(height),
        distortion: Distortion::None,
    }
}

fn wall(header: Header, camera: &CameraModel) -> Image {
    let pixels = camera.width as usize * camera.height as usize;
    Image {
        header,
        height: camera.height,
        width: camera.width,
        encoding: "32FC1".into(),
        is_bigendian: 0,
        step: 4 * camera.width,
        data: WALL_M.to_le_bytes().repeat(pixels),
    }
}

fn transforms(of: &Script, stamp_ns: u64) -> Vec<TransformStamped> {
    let edge = |parent: &str, child: &str, x: f64, z: f64, rotation: Quaternion| TransformStamped {
        header: Header::new(stamp_ns, parent),
        child_frame_id: child.into(),
        transform: Transform { translation: Vector3 { x, y: 0.0, z }, rotation },
    };
    // x to the right, y down, z ahead.
    let optical = Quaternion { x: -0.5, y: 0.5, z: -0.5, w: 0.5 };
    let mut edges = vec![
        edge("map", "base_link", of.x_m, 0.0, Quaternion::default()),
        edge("base_link", "eye", 0.0, 0.5, optical),
    ];
    if of.circle {
        edges.push(edge("eye", "map", 0.0, 0.0, Quaternion::default()));
    }
    edges
}
