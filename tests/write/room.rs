//! The analytic room against sums done by hand, and the committed recording of it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use byteorder::LittleEndian;
use glam::DVec3;
use limpid::base::Rigid;
use serde_bytes::ByteBuf;

use crate::support::drive;
use crate::support::room::{AxisAlignedBox, Room};

/// Looks along the map's x axis from the middle of an empty 4 m x 4 m room.
fn level_camera(height_m: f64) -> Rigid {
    Rigid::new([0.0, 0.0, height_m], [-0.5, 0.5, -0.5, 0.5]).unwrap()
}

fn pixel(u: usize, v: usize) -> usize {
    v * 160 + u
}

#[test]
fn wall_has_its_distance_and_floor_its_perspective() {
    let depth_m = Room::empty([4.0, 4.0]).depth(&drive::camera(), level_camera(0.6));
    // The wall is at x = 2 whatever the pixel: depth is along the axis, not along the ray.
    for (u, v) in [(0, 40), (79, 0), (159, 59), (80, 60)] {
        assert!((depth_m[pixel(u, v)] - 2.0).abs() < 1e-6, "({u}, {v}): {}", depth_m[pixel(u, v)]);
    }
    // The floor at row v lies at 0.6 m * fy / (v - cy).
    for v in [110, 119] {
        let floor_m = 0.6 * 146.0 / (v as f64 - 59.5);
        assert!((f64::from(depth_m[pixel(80, v)]) - floor_m).abs() < 1e-6, "row {v}");
    }
}

#[test]
fn boxes_hide_what_is_behind_and_miss_gives_zero() {
    let mut room = Room::empty([4.0, 4.0]);
    room.boxes.push(AxisAlignedBox::new([1.0, -0.1, 0.0], [1.2, 0.1, 0.8], [0.5; 3]));
    let depth_m = room.depth(&drive::camera(), level_camera(0.6));
    assert!((depth_m[pixel(80, 60)] - 1.0).abs() < 1e-6);
    assert!((depth_m[pixel(80 + 16, 60)] - 2.0).abs() < 1e-6, "beside the box");
    room.boxes.clear();
    assert!(room.depth(&drive::camera(), level_camera(0.6)).iter().all(|&d| d == 0.0));
}

#[test]
fn truth_knows_heights() {
    let room = Room::living_room();
    let band = |x, y| room.occupied_at(x, y, 0.1, 2.0);
    assert!(band(0.5, 0.8), "crate");
    assert!(band(1.5, -1.0), "table top");
    assert!(!room.occupied_at(1.5, -1.0, 0.1, 0.7), "under the table top");
    assert!(band(3.05, 0.0), "wall");
    assert!(!band(-0.3, 0.0), "mat");
    assert!(!band(-1.0, 1.5), "slab at 2.2 m");
    assert!(room.occupied_at(-1.0, 1.5, 0.1, 2.25), "slab at 2.2 m, tall robot");
    assert!(!band(-1.8, -1.2), "where the robot starts");
}

#[test]
fn colours_tell_the_objects_apart() {
    let (room, camera) = (Room::living_room(), drive::camera());
    let rgb = room.color(&camera, drive::map_from_camera(drive::image_stamp_ns(0)));
    assert_eq!(rgb.len(), 160 * 120 * 3);
    let colors: std::collections::BTreeSet<_> = rgb.chunks(3).collect();
    assert!(colors.len() >= 6, "{} colours", colors.len());
}

#[test]
fn the_robot_never_drives_into_something() {
    let room = Room::living_room();
    for index in 0..drive::FRAMES {
        let DVec3 { x, y, .. } = drive::map_from_base(drive::image_stamp_ns(index)).translation_m;
        for (dx, dy) in [(0.2, 0.0), (-0.2, 0.0), (0.0, 0.2), (0.0, -0.2)] {
            assert!(!room.occupied_at(x + dx, y + dy, 0.1, 2.0), "frame {index} at ({x}, {y})");
        }
    }
}

type Header = ((i32, u32), String);
type Image = (Header, u32, u32, String, u8, u32, ByteBuf);
type Compressed = (Header, String, ByteBuf);

/// Stamp and parent, child, translation and rotation.
type Edge = (Header, String, [f64; 7]);
type Transforms = Vec<Edge>;

/// Metres and quaternion parts; another machine's sine may differ in its last bits.
const POSE_TOLERANCE: f64 = 1e-12;
/// Depth may differ by a rounding where another machine's sine does.
const DEPTH_TOLERANCE_MM: u16 = 1;
/// Brightness may differ a little where another version of the encoder rounds otherwise.
const COLOR_TOLERANCE: u8 = 6;

fn committed() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("testdata/room.mcap")
}

fn messages(file: &[u8]) -> BTreeMap<String, Vec<(u64, String, Vec<u8>)>> {
    let mut topics = BTreeMap::<_, Vec<_>>::new();
    for message in mcap::MessageStream::new(file).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap().name.clone();
        let entry = (message.log_time, schema, message.data.to_vec());
        topics.entry(message.channel.topic.clone()).or_default().push(entry);
    }
    topics
}

fn decode<'a, T: serde::Deserialize<'a>>(data: &'a [u8]) -> T {
    cdr_encoding::from_bytes::<T, LittleEndian>(&data[4..]).unwrap().0
}

fn depths(data: &[u8]) -> Vec<u16> {
    let (_, height, width, encoding, big, step, bytes) = decode::<Image>(data);
    assert_eq!((height, width, encoding.as_str(), big, step), (120, 160, "16UC1", 0, 320));
    bytes.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect()
}

fn colors(data: &[u8]) -> Vec<u8> {
    image::load_from_memory(&decode::<Compressed>(data).2).unwrap().to_rgb8().into_raw()
}

/// The description of the first difference between two messages of a topic.
fn difference(topic: &str, a: &[u8], b: &[u8]) -> Option<String> {
    if topic.ends_with("compressed") {
        let (a, b) = (colors(a), colors(b));
        let worst = a.iter().zip(&b).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        (a.len() != b.len() || worst > COLOR_TOLERANCE).then(|| format!("colours differ by {worst}"))
    } else if topic.ends_with("image_raw") {
        let (a, b) = (depths(a), depths(b));
        let worst = a.iter().zip(&b).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        (a.len() != b.len() || worst > DEPTH_TOLERANCE_MM).then(|| format!("depths differ by {worst} mm"))
    } else if topic.starts_with("/tf") {
        let (a, b) = (decode::<Transforms>(a), decode::<Transforms>(b));
        let same = a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| same_edge(a, b));
        (!same).then(|| format!("{a:?} is not {b:?}"))
    } else {
        (a != b).then(|| "bytes differ".into())
    }
}

fn same_edge(a: &Edge, b: &Edge) -> bool {
    let ((a_header, a_child, a_pose), (b_header, b_child, b_pose)) = (a, b);
    let close = a_pose.iter().zip(b_pose).all(|(a, b)| (a - b).abs() < POSE_TOLERANCE);
    (a_header, a_child) == (b_header, b_child) && close
}

#[test]
fn committed_recording_is_what_the_room_gives() {
    let fresh = drive::recording();
    if std::env::var_os("LIMPID_WRITE_TESTDATA").is_some() {
        std::fs::write(committed(), &fresh).unwrap();
    }
    let file = std::fs::read(committed()).unwrap();
    assert!(file.len() < 1 << 20, "{} bytes", file.len());

    let (expected, found) = (messages(&fresh), messages(&file));
    assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
    for (topic, expected) in &expected {
        assert_eq!(found[topic].len(), expected.len(), "{topic}");
        for (found, expected) in found[topic].iter().zip(expected) {
            assert_eq!((found.0, &found.1), (expected.0, &expected.1), "{topic}: stamp and type");
            assert_eq!(difference(topic, &found.2, &expected.2), None, "{topic} at {}", found.0);
        }
    }
    let counts: Vec<_> = found.values().map(Vec::len).collect();
    assert_eq!(counts, [30, 30, 30, 30, 89, 1], "{:?}", found.keys());
}

#[test]
fn comparison_with_the_committed_recording_can_fail() {
    let topics = messages(&std::fs::read(committed()).unwrap());
    for (topic, messages) in topics.iter().filter(|(_, messages)| messages.len() > 1) {
        assert_eq!(difference(topic, &messages[3].2, &messages[3].2), None, "{topic}");
        assert!(difference(topic, &messages[3].2, &messages[20].2).is_some(), "{topic}");
    }
}
