//! Two cameras at 30 Hz, a lidar of 60,000 points at 10 Hz, tf at 200 Hz.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use limpid::message::ros2::{
    CameraInfo, Header, Image, PointCloud2, PointField, Quaternion, TFMessage, Transform, TransformStamped,
    Vector3, decode_cdr, encode_cdr,
};
use limpid::ros2::{Environment, Participant, Quality};
use limpid::{Error, Result};

use crate::Arguments;
use crate::beside::Beside;
use crate::recording::Recording;
use crate::soak::watch;

const CAMERAS: [&str; 2] = ["front", "rear"];
const CAMERA_HZ: f64 = 30.0;
const LIDAR_HZ: f64 = 10.0;
const TF_HZ: f64 = 200.0;
const POINTS: u32 = 60_000;
const RINGS: u32 = 32;

/// The robot's parameters.
const ROBOT: &str = "
map: {frame: odom, publish_rate_hz: 10.0}
sensors: [front, rear, top]
front: {kind: camera, depth_topic: /front/depth/image_raw, method: range}
rear: {kind: camera, depth_topic: /rear/depth/image_raw, method: range}
top: {kind: lidar, topic: /points}
";

pub(crate) fn run(arguments: &Arguments, length: Duration) -> Result<()> {
    let recording = Recording::read(&arguments.recording)?;
    let depth = recording.messages.iter().find(|message| message.topic == recording.depth);
    let depth = depth.ok_or(Error::Empty { reason: "it has no depth images".into() })?;
    let image: Image = decode_cdr("Image", &depth.payload)?;
    let parameters = std::env::temp_dir().join(format!("limpid-load-{}.yaml", std::process::id()));
    std::fs::write(&parameters, ROBOT).map_err(Error::file(&parameters))?;
    let node = ["-c".to_owned(), parameters.display().to_string()];
    let beside = Beside::start(&arguments.program, &node)?;
    let stop = Arc::new(AtomicBool::new(false));
    let start = |work: fn(&Environment, &AtomicBool, &Image) -> Result<()>| {
        let (environment, stop, image) = (beside.environment.clone(), Arc::clone(&stop), image.clone());
        thread::spawn(move || work(&environment, &stop, &image))
    };
    let threads = [start(transforms), start(cameras), start(lidar)];
    let flat = watch(&beside, length);
    stop.store(true, Ordering::Relaxed);
    for thread in threads {
        thread.join().map_err(|_| Error::Empty { reason: "a publisher panicked".into() })??;
    }
    std::fs::remove_file(&parameters).map_err(Error::file(&parameters))?;
    flat
}

/// Calls `work` with the time as a stamp, so often a second.
fn at_rate(hz: f64, stop: &AtomicBool, mut work: impl FnMut(u64) -> Result<()>) -> Result<()> {
    let mut next = Instant::now();
    while !stop.load(Ordering::Relaxed) {
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        work(now.map_or(0, |now| u64::try_from(now.as_nanos()).unwrap_or(0)))?;
        next += Duration::from_secs_f64(1.0 / hz);
        thread::sleep(next.saturating_duration_since(Instant::now()));
    }
    Ok(())
}

fn transforms(environment: &Environment, stop: &AtomicBool, _: &Image) -> Result<()> {
    let participant = Participant::join(environment)?;
    let tf = participant.publish("/tf", "tf2_msgs/msg/TFMessage", Quality::Stream { depth: 100 })?;
    at_rate(TF_HZ, stop, |stamp_ns| {
        let edge = |parent: &str, child: &str, x: f64, z: f64, rotation: Quaternion| TransformStamped {
            header: Header::new(stamp_ns, parent),
            child_frame_id: child.into(),
            transform: Transform { translation: Vector3 { x, y: 0.0, z }, rotation },
        };
        #[expect(clippy::cast_precision_loss, reason = "seconds")]
        let seconds = (stamp_ns % 60_000_000_000) as f64 * 1e-9;
        // Half a metre a second, there and back.
        let x_m = 0.5 * if seconds < 30.0 { seconds } else { 60.0 - seconds };
        let ahead = Quaternion { x: -0.5, y: 0.5, z: -0.5, w: 0.5 };
        let back = Quaternion { x: 0.5, y: 0.5, z: -0.5, w: -0.5 };
        let transforms = vec![
            edge("odom", "base_link", x_m, 0.0, Quaternion::default()),
            edge("base_link", "front", 0.2, 0.5, ahead),
            edge("base_link", "rear", -0.2, 0.5, back),
            edge("base_link", "top", 0.0, 0.8, Quaternion::default()),
        ];
        tf.send(encode_cdr("TFMessage", &TFMessage { transforms })?).map(drop)
    })
}

fn cameras(environment: &Environment, stop: &AtomicBool, image: &Image) -> Result<()> {
    let participant = Participant::join(environment)?;
    let topics = CAMERAS.map(|name| {
        let publish = |topic: &str, kind: &str| {
            participant.publish(&format!("/{name}/depth/{topic}"), kind, Quality::Sensor)
        };
        Ok((
            publish("image_raw", "sensor_msgs/msg/Image")?,
            publish("camera_info", "sensor_msgs/msg/CameraInfo")?,
        ))
    });
    let topics: Vec<_> = topics.into_iter().collect::<Result<_>>()?;
    let (width, height) = (image.width, image.height);
    let f = f64::from(width) * 0.9;
    let centre = |pixels: u32| f64::from(pixels) / 2.0;
    let model = limpid::sensor::CameraModel {
        width,
        height,
        fx: f,
        fy: f,
        cx: centre(width),
        cy: centre(height),
        distortion: limpid::sensor::Distortion::None,
    };
    at_rate(CAMERA_HZ, stop, |stamp_ns| {
        for (name, (images, infos)) in CAMERAS.iter().zip(&topics) {
            let header = Header::new(stamp_ns, name);
            infos.send(encode_cdr("CameraInfo", &CameraInfo::new(header.clone(), &model))?)?;
            images.send(encode_cdr("Image", &Image { header, ..image.clone() })?)?;
        }
        Ok(())
    })
}

fn lidar(environment: &Environment, stop: &AtomicBool, _: &Image) -> Result<()> {
    let participant = Participant::join(environment)?;
    let points = participant.publish("/points", "sensor_msgs/msg/PointCloud2", Quality::Sensor)?;
    let data = cylinder();
    let field =
        |name: &str, offset: u32, datatype: u8| PointField { name: name.into(), offset, datatype, count: 1 };
    let fields = vec![
        field("x", 0, 7),
        field("y", 4, 7),
        field("z", 8, 7),
        field("intensity", 12, 7),
        field("ring", 16, 4),
    ];
    at_rate(LIDAR_HZ, stop, |stamp_ns| {
        let cloud = PointCloud2 {
            header: Header::new(stamp_ns, "top"),
            height: 1,
            width: POINTS,
            fields: fields.clone(),
            is_bigendian: 0,
            point_step: 20,
            row_step: 20 * POINTS,
            data: data.clone(),
            is_dense: 1,
        };
        points.send(encode_cdr("PointCloud2", &cloud)?).map(drop)
    })
}

/// Walls all around at 5 m, and the floor.
fn cylinder() -> Vec<u8> {
    let mut data = Vec::with_capacity(20 * POINTS as usize);
    for at in 0..POINTS {
        let (ring, step) = (at % RINGS, at / RINGS);
        let azimuth = std::f64::consts::TAU * f64::from(step) / f64::from(POINTS / RINGS);
        let elevation = (f64::from(ring) - 20.0).to_radians();
        // The floor lies 0.8 m below.
        let to_floor = if elevation < 0.0 { 0.8 / -elevation.sin() } else { f64::INFINITY };
        let range = (5.0 / elevation.cos()).min(to_floor);
        let flat = range * elevation.cos();
        for value in [flat * azimuth.cos(), flat * azimuth.sin(), range * elevation.sin(), 80.0] {
            #[expect(clippy::cast_possible_truncation, reason = "a field of 32 bits")]
            data.extend((value as f32).to_le_bytes());
        }
        data.extend(u16::try_from(ring).unwrap_or(0).to_le_bytes());
        data.extend([0, 0]);
    }
    data
}
