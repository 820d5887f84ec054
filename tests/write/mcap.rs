//! The MCAP output, decoded field by field from its bytes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use byteorder::LittleEndian;
use limpid::map::Update;
use limpid::mapper::SensorInfo;
use limpid::output::{McapSink, Sink, occupancy_of_cost};
use limpid::sensor::{DepthSamples, Distortion, Observation};
use limpid::{Config, Error};
use serde::Deserialize;
use serde_bytes::ByteBuf;
use tempfile::TempDir;

use crate::support::sample;

pub(super) type Time = (i32, u32);
pub(super) type Header = (Time, String);
pub(super) type Transform = ([f64; 3], [f64; 4]);
type Grid = (Header, (Time, f32, u32, u32, Transform), ByteBuf);
type Costmap = (Header, (Time, Time, String, f32, u32, u32, Transform), ByteBuf);
type Image = (Header, u32, u32, String, u8, u32, ByteBuf);
type Calibration =
    (Header, u32, u32, String, Vec<f64>, [f64; 9], [f64; 9], [f64; 12], [u32; 2], ([u32; 4], bool));
pub(super) type Transforms = Vec<(Header, String, Transform)>;
pub(super) type Diagnostics = (Header, Vec<(u8, String, String, String, Vec<(String, String)>)>);

const STAMP: Time = (1_700_000_001, 234_567_890);
const DEPTH_STAMP: Time = (1_700_000_001, 241_567_890);

pub(super) struct Message {
    pub(super) topic: String,
    pub(super) schema_name: String,
    pub(super) schema: Vec<u8>,
    pub(super) log_time: u64,
    pub(super) data: Vec<u8>,
}

pub(super) fn read(path: &Path) -> Vec<Message> {
    let bytes = std::fs::read(path).unwrap();
    let summary = ::mcap::Summary::read(&bytes).unwrap().expect("has a summary");
    assert_eq!(summary.chunk_indexes.first().unwrap().compression, "zstd");
    ::mcap::MessageStream::new(&bytes).unwrap().map(|message| own(&message.unwrap())).collect()
}

fn own(message: &::mcap::Message<'_>) -> Message {
    let schema = message.channel.schema.as_ref().unwrap();
    // rosbag2 before 0.35 does not play a file of several encodings.
    let encodings = (schema.encoding.as_str(), message.channel.message_encoding.as_str());
    assert_eq!(encodings, ("ros2msg", "cdr"));
    assert_eq!(message.log_time, message.publish_time);
    assert_eq!(message.data[..4], [0, 1, 0, 0], "CDR little endian");
    Message {
        topic: message.channel.topic.clone(),
        schema_name: schema.name.clone(),
        schema: schema.data.to_vec(),
        log_time: message.log_time,
        data: message.data.to_vec(),
    }
}

/// The only message of `topic`, all its bytes used.
pub(super) fn decode<T: for<'a> Deserialize<'a>>(messages: &[Message], topic: &str) -> T {
    let mut of_topic = messages.iter().filter(|m| m.topic == topic);
    let message = of_topic.next().unwrap_or_else(|| panic!("no message on {topic}"));
    assert!(of_topic.next().is_none(), "more than one message on {topic}");
    let (value, used) = cdr_encoding::from_bytes::<T, LittleEndian>(&message.data[4..]).unwrap();
    assert_eq!(used, message.data.len() - 4, "{topic}: bytes left over");
    value
}

fn write(observation: &Observation, update: &Update) -> (TempDir, PathBuf) {
    write_with(&Config { cloud_stride: 1, ..Config::default() }, observation, update)
}

fn write_with(config: &Config, observation: &Observation, update: &Update) -> (TempDir, PathBuf) {
    write_all(config, &[sample::camera("camera", config)], &[(update, Some(observation))])
}

pub(super) fn write_all(
    config: &Config,
    sensors: &[SensorInfo],
    results: &[(&Update, Option<&Observation>)],
) -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("out.mcap");
    let mut sink = McapSink::create(&path, config, sensors).unwrap();
    for (update, observation) in results {
        sink.write(update, *observation).unwrap();
    }
    sink.finish().unwrap();
    (folder, path)
}

fn written(observation: &Observation, update: &Update) -> Vec<Message> {
    read(&write(observation, update).1)
}

fn sample_messages() -> Vec<Message> {
    written(&sample::input(), &sample::output())
}

#[test]
fn topics_types_and_times() {
    let messages = sample_messages();
    let found: BTreeMap<_, _> =
        messages.iter().map(|m| (m.topic.as_str(), (m.schema_name.as_str(), m.log_time))).collect();
    let (stamp, depth) = (sample::STAMP_NS, sample::DEPTH_STAMP_NS);
    let expected = BTreeMap::from([
        ("/limpid/costmap", ("nav_msgs/msg/OccupancyGrid", stamp)),
        ("/limpid/costmap_raw", ("nav2_msgs/msg/Costmap", stamp)),
        ("/limpid/depth_filtered/camera_info", ("sensor_msgs/msg/CameraInfo", depth)),
        ("/limpid/depth_filtered/image", ("sensor_msgs/msg/Image", depth)),
        ("/limpid/diagnostics", ("diagnostic_msgs/msg/DiagnosticArray", stamp)),
        ("/limpid/points_trusted", ("sensor_msgs/msg/PointCloud2", depth)),
        ("/limpid/reliability", ("sensor_msgs/msg/Image", depth)),
        ("/limpid/reliability_float", ("sensor_msgs/msg/Image", depth)),
        ("/tf", ("tf2_msgs/msg/TFMessage", depth)),
    ]);
    assert_eq!(found, expected);
}

#[test]
fn header_says_ros2() {
    let (_folder, path) = write(&sample::input(), &sample::output());
    let bytes = std::fs::read(path).unwrap();
    // Magic (8), opcode (1), length (8), then the profile as a string with a 32-bit length.
    assert_eq!(&bytes[17..25], b"\x04\0\0\0ros2");
}

#[test]
fn schemas_define_every_type_they_use() {
    let maps = write_all(&Config::default(), &sample::alone(), &[(&sample::published(), None)]);
    for message in sample_messages().into_iter().chain(read(&maps.1)) {
        let schema = std::str::from_utf8(&message.schema).unwrap();
        let parts: Vec<_> = schema.split(&format!("{}\n", "=".repeat(80))).collect();
        let names: Vec<_> =
            parts[1..].iter().map(|p| p.lines().next().unwrap().strip_prefix("MSG: ").unwrap()).collect();
        let types = schema.lines().filter(|l| !l.starts_with(['#', 'M']));
        let used = types.filter_map(|l| l.split([' ', '[']).next()).filter(|t| t.contains('/'));
        for used in used {
            assert!(names.contains(&used), "{}: {used} is not defined", message.schema_name);
        }
        assert!(names.contains(&"builtin_interfaces/Time"), "{}", message.schema_name);
    }
}

#[test]
fn grids_hold_geometry_and_costs() {
    let (messages, costmap) = (sample_messages(), sample::output().map.unwrap().costmap);
    let origin = ([1.05, -2.45, 0.0], [0.0, 0.0, 0.0, 1.0]);
    let (header, info, data) = decode::<Grid>(&messages, "/limpid/costmap");
    assert_eq!(header, (STAMP, "map".into()));
    assert_eq!(info, (STAMP, 0.05, 16, 17, origin));
    for (cell, (&value, &cost)) in data.iter().zip(&costmap).enumerate() {
        assert_eq!(value.cast_signed(), nav2_translation(cost), "cell {cell}");
    }
    assert_eq!(data.len(), costmap.len());

    let (header, metadata, data) = decode::<Costmap>(&messages, "/limpid/costmap_raw");
    assert_eq!(header, (STAMP, "map".into()));
    assert_eq!(metadata, (STAMP, STAMP, "limpid".into(), 0.05, 16, 17, origin));
    assert_eq!(data.as_slice(), costmap);
}

/// The text of nav2's rule, in floating point: 1..=252 are scaled to 1..=98 and cut off.
fn nav2_translation(cost: u8) -> i8 {
    if cost == 255 {
        return -1;
    }
    let scaled = 1.0 + (97.0 * (f64::from(cost) - 1.0) / 251.0 + 1e-9).floor();
    match cost {
        0 => 0,
        1..=252 => format!("{scaled}").parse().unwrap(),
        253 => 99,
        _ => 100,
    }
}

#[test]
fn occupancy_agrees_with_nav2_for_every_cost() {
    let table: Vec<_> = (0..=255).map(occupancy_of_cost).collect();
    assert_eq!(table, (0..=255).map(nav2_translation).collect::<Vec<_>>());
    // Values by hand: 97 * 127 / 251 = 49.08, 97 * 250 / 251 = 96.6.
    assert_eq!(
        [0, 1, 3, 4, 128, 251, 252, 253, 254, 255].map(|c| table[c]),
        [0, 1, 1, 2, 50, 97, 98, 99, 100, -1]
    );
}

#[test]
fn reliability_comes_as_bytes_and_as_floats() {
    let messages = sample_messages();
    let (header, height, width, encoding, big, step, data) =
        decode::<Image>(&messages, "/limpid/reliability");
    assert_eq!((height, width, encoding.as_str(), big, step), (2, 3, "mono8", 0, 3));
    assert_eq!(header, (DEPTH_STAMP, "optical".into()));
    assert_eq!(data.as_slice(), [255, 128, 77, 77, 0, 0], "R * 255 rounded");

    let (header, height, width, encoding, big, step, data) =
        decode::<Image>(&messages, "/limpid/reliability_float");
    assert_eq!((height, width, encoding.as_str(), big, step), (2, 3, "32FC1", 0, 12));
    assert_eq!(header, (DEPTH_STAMP, "optical".into()));
    assert_eq!(floats(&data), sample::RELIABILITY);
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

#[test]
fn filtered_depth_keeps_encoding_and_drops_up_to_tau() {
    let messages = sample_messages();
    let (header, height, width, encoding, _, step, data) =
        decode::<Image>(&messages, "/limpid/depth_filtered/image");
    assert_eq!((height, width, encoding.as_str(), step), (2, 3, "16UC1", 6));
    assert_eq!(header, (DEPTH_STAMP, "optical".into()));
    let raw: Vec<_> = data.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
    assert_eq!(raw, [1000, 1001, 0, 1003, 0, 0], "tau = 0.3 itself is dropped");

    let metres = DepthSamples::Metres(vec![1.5, f32::NAN, 2.5, 3.5, f32::INFINITY, -1.0]);
    let messages = written(&sample::observed(sample::frame(metres)), &sample::output());
    let (_, _, _, encoding, _, step, data) = decode::<Image>(&messages, "/limpid/depth_filtered/image");
    assert_eq!((encoding.as_str(), step), ("32FC1", 12));
    let found = floats(&data);
    assert!(found[1].is_nan(), "a trusted sample stays as it was");
    assert_eq!([found[0], found[2], found[3], found[4], found[5]], [1.5, 0.0, 3.5, 0.0, 0.0]);
}

#[test]
fn trusted_points_are_the_pixels_above_tau() {
    type Cloud = (Header, u32, u32, Vec<(String, u32, u8, u32)>, bool, u32, u32, ByteBuf, bool);
    let topic = "/limpid/points_trusted";
    let (header, height, width, fields, big, step, row_step, data, dense): Cloud =
        decode(&sample_messages(), topic);
    assert_eq!(header, (DEPTH_STAMP, "optical".into()));
    assert_eq!((height, width, big, step, row_step, dense), (1, 3, false, 16, 48, true));
    let named = |name: &str, offset| (name.to_string(), offset, 7, 1);
    assert_eq!(fields, [named("x", 0), named("y", 4), named("z", 8), named("reliability", 12)]);
    // Focal length 146, centre (79.5, 59.5); pixels 0, 1 and 3 of a row of three: the third is tau itself.
    let at = |u: f64, v: f64, d: f64, r| {
        [(d * (u - 79.5) / 146.0) as f32, (d * (v - 59.5) / 146.0) as f32, d as f32, r]
    };
    let want = [at(0.0, 0.0, 1.0, 1.0), at(1.0, 0.0, 1.001, 0.5), at(0.0, 1.0, 1.003, 0.301)].concat();
    assert!(
        floats(&data).iter().zip(&want).all(|(a, b)| (a - b).abs() < 1e-6),
        "{:?} {want:?}",
        floats(&data)
    );

    let input = sample::input();
    let strided = Config { cloud_stride: 2, ..Config::default() };
    let (_, _, width, .., dense): Cloud =
        decode(&read(&write_with(&strided, &input, &sample::output()).1), topic);
    assert_eq!((width, dense), (1, true), "pixel 0; pixel 2 is not trusted");
    let none = Config { cloud_stride: 0, ..Config::default() };
    let messages = read(&write_with(&none, &input, &sample::output()).1);
    assert!(messages.iter().all(|message| message.topic != topic));
}

#[test]
fn calibration_is_complete() {
    let topic = "/limpid/depth_filtered/camera_info";
    let k = [146.0, 0.0, 79.5, 0.0, 146.0, 59.5, 0.0, 0.0, 1.0];
    let r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let p = [146.0, 0.0, 79.5, 0.0, 0.0, 146.0, 59.5, 0.0, 0.0, 0.0, 1.0, 0.0];
    let lens = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8];
    let models = [
        (Distortion::None, "plumb_bob", vec![0.0; 5]),
        (Distortion::PlumbBob([1.0, 2.0, 3.0, 4.0, 5.0]), "plumb_bob", vec![1.0, 2.0, 3.0, 4.0, 5.0]),
        (Distortion::RationalPolynomial(lens), "rational_polynomial", lens.to_vec()),
    ];
    for (distortion, model, d) in models {
        let mut frame = sample::frame(sample::millimetres());
        frame.depth.camera.distortion = distortion;
        let found = decode::<Calibration>(&written(&sample::observed(frame), &sample::output()), topic);
        let header = (DEPTH_STAMP, "optical".into());
        assert_eq!(found, (header, 2, 3, model.into(), d, k, r, p, [0; 2], ([0; 4], false)));
    }
}

#[test]
fn transforms_reach_from_map_to_camera() {
    let (messages, output) = (sample_messages(), sample::output());
    let transforms = decode::<Transforms>(&messages, "/tf");
    let [base, camera] = transforms.as_slice() else { panic!("{transforms:?}") };
    assert_eq!((&base.0, base.1.as_str()), (&(DEPTH_STAMP, "map".into()), "base_link"));
    assert_eq!(base.2, ([1.5, -2.0, 0.25], [0.0, 0.0, 0.25_f64.sin(), 0.25_f64.cos()]));
    assert_eq!((&camera.0, camera.1.as_str()), (&(DEPTH_STAMP, "base_link".into()), "optical"));
    assert_eq!(camera.2.0, [0.15, 0.0, 0.6]);
    assert_eq!(camera.2.1, output.base_from_sensor.rotation.to_array());
}

#[test]
fn a_base_that_is_the_camera_is_not_its_own_parent() {
    let transforms = |frame_id: &str| {
        let mut frame = sample::frame(sample::millimetres());
        frame.depth.frame_id = frame_id.into();
        written(&sample::observed(frame), &sample::output())
    };
    let found = decode::<Transforms>(&transforms("base_link"), "/tf");
    assert_eq!(found.iter().map(|t| t.1.as_str()).collect::<Vec<_>>(), ["base_link"]);
    assert!(transforms("map").iter().all(|m| m.topic != "/tf"), "a map that is the camera's own frame");
}

#[test]
fn diagnostics_carry_state_counters_and_times() {
    let (header, status) = decode::<Diagnostics>(&sample_messages(), "/limpid/diagnostics");
    assert_eq!(header, (STAMP, String::new()));
    let [(level, name, message, hardware, values), map] = status.as_slice() else { panic!("{status:?}") };
    assert_eq!((*level, hardware.as_str()), (0, "optical"));
    assert_eq!(name, "limpid: depth reliability");
    assert_eq!((map.0, map.1.as_str(), map.2.as_str(), map.3.as_str()), (0, "limpid: map", "OK", "map"));
    assert_eq!(map.4, [("camera".to_string(), "OK".to_string())]);
    assert!(message.starts_with("OK"), "{message}");
    let value = |key: &str| values.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str());
    assert_eq!(value("low_reliability_fraction"), Some("0.5"));
    assert_eq!((value("pixels"), value("hits"), value("free_cells")), (Some("6"), Some("2"), Some("0")));
    assert_eq!((value("fuse_ms"), value("inflate_ms")), (Some("0.2500"), None));
    assert_eq!(value("ingest_ms"), Some("0.6250"), "two runs of a pass are summed");

    let messages = written(&sample::input(), &sample::with_camera(|camera| camera.degraded = true));
    let (_, status) = decode::<Diagnostics>(&messages, "/limpid/diagnostics");
    assert_eq!(status[0].0, 1, "WARN");
    assert!(status[0].2.starts_with("DEGRADED: 50 %"), "{}", status[0].2);
}

#[test]
fn without_images_only_grids_tf_and_diagnostics() {
    let messages = written(&sample::input(), &sample::with_camera(|camera| camera.images = None));
    let topics: Vec<_> = messages.iter().map(|m| m.topic.as_str()).collect();
    assert_eq!(topics, ["/limpid/costmap", "/limpid/costmap_raw", "/limpid/diagnostics", "/tf"]);
}

#[test]
fn images_of_another_size_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("out.mcap");
    let mut sink = McapSink::create(&path, &Config::default(), &sample::alone()).unwrap();
    let output = sample::with_images(|images| images.width = 2);
    let error = sink.write(&output, Some(&sample::input())).unwrap_err();
    assert!(matches!(&error, Error::Encode { path: p, .. } if *p == path), "{error}");

    let output = sample::with_map(|map| map.costmap.truncate(271));
    let error = sink.write(&output, Some(&sample::input())).unwrap_err();
    assert!(error.to_string().ends_with("271 costs do not fill a grid of 16x17 cells"), "{error}");
}

#[test]
fn finishing_twice_is_fine_and_writing_afterwards_is_an_error() {
    let folder = TempDir::new().unwrap();
    let mut sink =
        McapSink::create(&folder.path().join("out.mcap"), &Config::default(), &sample::alone()).unwrap();
    sink.finish().unwrap();
    sink.finish().unwrap();
    let error = sink.write(&sample::output(), Some(&sample::input())).unwrap_err();
    assert!(error.to_string().contains("out.mcap"), "{error}");
}

#[test]
fn a_dropped_sink_leaves_a_complete_file() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("out.mcap");
    let mut sink = McapSink::create(&path, &Config::default(), &sample::alone()).unwrap();
    sink.write(&sample::output(), Some(&sample::input())).unwrap();
    drop(sink);
    assert_eq!(read(&path).len(), 9);
}

#[test]
fn a_killed_run_leaves_what_was_flushed() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("out.mcap");
    let mut sink = McapSink::create(&path, &Config::default(), &sample::alone()).unwrap();
    for _ in 0..40 {
        sink.write(&sample::output(), Some(&sample::input())).unwrap();
    }
    let partial = folder.path().join("out.partial.mcap");
    let readable = readable(&partial, "/limpid/costmap");
    assert!((26..40).contains(&readable), "{readable} of 40 frames");
    sink.finish().unwrap();
    assert!(path.exists() && !partial.exists());
}

/// Messages of a topic that can be read as after a kill: what the operating system has now, no footer.
pub(super) fn readable(path: &Path, topic: &str) -> usize {
    let bytes = std::fs::read(path).unwrap();
    let options = ::mcap::read::Options::IgnoreEndMagic.into();
    let stream = ::mcap::MessageStream::new_with_options(&bytes, options).unwrap();
    stream.map_while(Result::ok).filter(|m| m.channel.topic == topic).count()
}
