//! Which of a recording's topics is the lidar, and what is said of the others.

use std::path::Path;

use limpid::message::ros2::{Header, PointCloud2, PointField};
use limpid::{Config, open_source};

use super::synthetic::{Recorder, Saved, at_ms};
use crate::cli::{fails, limpid};

const CLOUD: &str = "sensor_msgs/msg/PointCloud2";

/// Two points of 32-bit floats.
fn cloud(frame: &str, fields: &[&str]) -> PointCloud2 {
    let step = 4 * fields.len() as u32;
    let field =
        |(at, name): (u32, &&str)| PointField { name: (*name).into(), offset: 4 * at, datatype: 7, count: 1 };
    PointCloud2 {
        header: Header::new(at_ms(0), frame),
        height: 1,
        width: 2,
        fields: (0..).zip(fields).map(field).collect(),
        is_bigendian: 0,
        point_step: step,
        row_step: 2 * step,
        data: (0..2 * fields.len()).flat_map(|value| (1.0 + value as f32).to_le_bytes()).collect(),
        is_dense: 1,
    }
}

fn recording(clouds: &[(&str, &str, &[&str])], depth: bool) -> Saved {
    let mut recorder = Recorder::new();
    if depth {
        recorder.depth(at_ms(0), 1000);
    }
    for (topic, frame, fields) in clouds {
        recorder.ros(topic, CLOUD, at_ms(0), &cloud(frame, fields));
    }
    recorder.save()
}

/// The sensors that are found, and the notes.
fn found(path: &Path, config: &Config) -> (Vec<String>, String) {
    let mut source = open_source(path, config).unwrap();
    while source.next().unwrap().is_some() {}
    let names = source.sensors().iter().map(|sensor| sensor.name.clone()).collect();
    (names, source.report().read.notes.join("\n"))
}

const XYZ: &[&str] = &["x", "y", "z"];
const XYZI: &[&str] = &["x", "y", "z", "intensity"];
const XYZIT: &[&str] = &["x", "y", "z", "intensity", "time", "ring"];
const XYZRGB: &[&str] = &["x", "y", "z", "rgb"];

#[test]
fn a_cloud_that_has_what_is_needed_comes_before_one_that_lacks_it() {
    for (clouds, best) in [
        ([("/a", "lidar", XYZ), ("/b", "lidar", XYZI), ("/c", "lidar", XYZIT)], "/c"),
        (
            [("/a", "lidar", &["x", "y", "intensity"][..]), ("/b", "lidar", XYZ), ("/c", "lidar", XYZRGB)],
            "/b",
        ),
        ([("/a", "map", XYZIT), ("/b", "lidar", XYZ), ("/c", "odom", XYZI)], "/b"),
        ([("/a", "lidar", XYZI), ("/b", "lidar", XYZI), ("/c", "lidar", XYZ)], "/a"),
    ] {
        let saved = recording(&clouds, false);
        let (sensors, notes) = found(&saved.path, &Config::default());
        assert_eq!(sensors, ["lidar"]);
        let others = clouds.iter().map(|cloud| cloud.0).filter(|topic| *topic != best).collect::<Vec<_>>();
        let said = format!("topic: {best} (others with scans: {})", others.join(", "));
        assert!(notes.contains(&said), "{notes}");
    }
}

#[test]
fn a_camera_s_own_cloud_beside_its_depth_images_is_no_lidar() {
    for (frame, fields) in [("cam_optical", XYZRGB), ("camera_depth_optical_frame", XYZ)] {
        let clouds = [("/cam/depth/points", frame, fields)];
        let (sensors, notes) = found(&recording(&clouds, true).path, &Config::default());
        assert_eq!(sensors, ["camera"], "{notes}");
        assert!(notes.contains("/cam/depth/points is left out") && notes.contains("`scan_topic`"), "{notes}");
        let stated = Config { scan_topic: "/cam/depth/points".into(), ..Config::default() };
        assert!(found(&recording(&clouds, true).path, &stated).0.contains(&"lidar".into()));
        // Without depth images it is all there is.
        assert_eq!(found(&recording(&clouds, false).path, &Config::default()).0, ["lidar"]);
        let both = [clouds[0], ("/points", "lidar", XYZ)];
        let (sensors, notes) = found(&recording(&both, true).path, &Config::default());
        assert!(sensors == ["camera", "lidar"] && notes.contains("topic: /points"), "{notes}");
    }
}

#[test]
fn packets_that_are_not_decoded_are_named_and_what_to_record() {
    for (schema, sensor) in [
        ("ouster_sensor_msgs/msg/PacketMsg", "an Ouster sensor"),
        ("ouster_ros/msg/PacketMsg", "an Ouster sensor"),
        ("pandar_msgs/msg/PandarScan", "a Hesai sensor"),
        ("hesai_ros_driver/msg/UdpFrame", "a Hesai sensor"),
        ("nebula_msgs/msg/NebulaPackets", "a sensor of the Nebula driver"),
        ("rslidar_msg/msg/RslidarPacket", "a RoboSense sensor"),
        ("acme_msgs/msg/BatchedPackets", "a sensor"),
    ] {
        let mut recorder = Recorder::new();
        recorder.bytes("/lidar/packets", schema, "cdr", at_ms(0), &[0, 1, 0, 0]);
        recorder.transform("/tf", at_ms(0), ["map", "base_link"], [0.0; 3], [0.0, 0.0, 0.0, 1.0]);
        let saved = recorder.save();
        let output = limpid(&["run", saved.path.to_str().unwrap()]);
        fails(&output, 1, &["/lidar/packets", schema, sensor, "not decoded", "sensor_msgs/PointCloud2"]);
        assert!(!String::from_utf8_lossy(&output.stderr).contains("depth"), "{output:?}");
        // Beside something that is read it is a note.
        let mut recorder = Recorder::new();
        recorder.bytes("/lidar/packets", schema, "cdr", at_ms(0), &[0, 1, 0, 0]);
        recorder.ros("/points", CLOUD, at_ms(0), &cloud("lidar", XYZI));
        let (sensors, notes) = found(&recorder.save().path, &Config::default());
        assert!(sensors == ["lidar"] && notes.contains(sensor), "{notes}");
    }
}

#[test]
fn packets_of_images_are_no_lidar() {
    for schema in ["theora_image_transport/msg/Packet", "ffmpeg_image_transport_msgs/msg/FFMPEGPacket"] {
        let mut recorder = Recorder::new();
        recorder.bytes("/cam/packets", schema, "cdr", at_ms(0), &[0, 1, 0, 0]);
        let output = limpid(&["run", recorder.save().path.to_str().unwrap()]);
        fails(&output, 1, &["no depth image"]);
    }
}

#[test]
fn a_lidar_alone_that_gives_nothing_is_told_of_in_its_words() {
    let saved = recording(&[("/points", "lidar", &["x", "y"])], false);
    let output = limpid(&["run", saved.path.to_str().unwrap()]);
    fails(&output, 1, &["no field `z`", "its fields: x, y"]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(!text.contains("depth") && !text.contains("camera"), "{text}");
}

#[test]
fn coordinates_that_cannot_be_metres_are_refused() {
    let mut millimetres = cloud("lidar", XYZI);
    let mut place = |range_mm: f32| {
        millimetres.data = [range_mm, 100.0, -800.0, 7.0]
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect::<Vec<_>>()
            .repeat(2);
        let mut recorder = Recorder::new();
        recorder.ros("/points", CLOUD, at_ms(0), &millimetres);
        limpid(&["run", recorder.save().path.to_str().unwrap()])
    };
    fails(&place(3000.0), 1, &["half of its points lie more than 3106 m", "millimetres", "must be metres"]);
    if !crate::support::gpu::skipped() {
        crate::cli::succeeds(&place(450.0));
    }
}
