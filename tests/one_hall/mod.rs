//! A hall with a wall of glass, two cameras and a lidar in one recording: one map, through the command.

mod picture;
mod why;

use std::path::{Path, PathBuf};
use std::process::Command;

use byteorder::LittleEndian;
use glam::{DQuat, DVec3};
use limpid::base::Rigid;
use limpid::message::ros2::{CameraInfo, Image, PointCloud2};
use limpid::output::cloud::{FLOAT32, cloud};
use limpid::sensor::Scan;
use serde::Deserialize;
use serde_bytes::ByteBuf;

use crate::read::synthetic::{Recorder, Saved, at_ms, header};
use crate::support::glass_room::{GlassRoom, WALL_X_M};
use crate::support::gpu::skipped;
use crate::support::scene::{Block, Scene, pose, small_camera};

/// The lidar above the floor, metres: the analytic room's floor lies that much below its sensor.
const LIDAR_HEIGHT_M: f64 = 1.2;
const CAMERA_HEIGHT_M: f64 = 0.6;
const CAMERA_PITCH_RAD: f64 = 0.3;

/// Sensors as the configuration counts them, from 1.
const FRONT: u8 = 1;
const REAR: u8 = 2;
const TOP: u8 = 3;

const CONFIG: &str = "\
limpid:
  ros__parameters:
    map: {frame: map, base_frame: base_link, size_m: 16.0, resolution_m: 0.1, publish_rate_hz: 10.0}
    sensors: [front, rear, top]
    front:
      {kind: camera, depth_topic: /front/depth/image_raw, method: range, range_gate_m: 8.0, mark_range_m: 8.0}
    rear: {kind: camera, depth_topic: /rear/depth/image_raw, method: range, timeout_s: 0.3}
    top:
      kind: lidar
      topic: /points
      glass: true
      intensity_full_scale: 255.0
      gamma: 0.08
      layer_heights_m: [-1.0, -0.5, 0.0, 0.3]
";

/// What the pane shows to a camera, and is nowhere.
const MIRRORED: Block = Block { min: DVec3::new(5.0, 0.6, 0.2), max: DVec3::new(5.4, 1.0, 0.9) };

/// What a depth camera sees of the room: it looks through the pane at what stands outside, and sees something mirrored in it.
/// The low box stands under the beams of the lidar, which therefore says nothing of it.
fn scene() -> Scene {
    let (wall, out) = (WALL_X_M, WALL_X_M + 0.1);
    Scene::of(&[
        Block::new([wall, -3.6, 0.0], [out, -2.0, 3.0]),
        Block::new([wall, 2.0, 0.0], [out, 3.6, 3.0]),
        Block::new([wall, -2.0, 0.0], [out, 2.0, 0.3]),
        Block::new([wall, -2.0, 2.6], [out, 2.0, 3.0]),
        Block::new([-4.1, -3.6, 0.0], [-4.0, 3.6, 3.0]),
        Block::new([-4.0, 3.5, 0.0], [wall, 3.6, 3.0]),
        Block::new([-4.0, -3.6, 0.0], [wall, -3.5, 3.0]),
        // The cupboard, the thing outside, what is mirrored, the low box.
        Block::new([-4.0, 1.5, 0.0], [-3.0, 3.5, 2.1]),
        Block::new([6.4, -1.6, 0.0], [6.9, -0.3, 1.0]),
        MIRRORED,
        Block::new([1.1, -0.4, 0.0], [1.4, -0.1, 0.25]),
    ])
}

/// The base turns slowly while it drives.
fn map_from_base(ms: u64) -> Rigid {
    let seconds = ms as f64 * 1e-3;
    Rigid {
        rotation: DQuat::from_rotation_z(0.1 * seconds),
        translation_m: DVec3::new(0.3 + 0.1 * seconds, 0.2, 0.0),
    }
}

/// A camera in the base, looking ahead or back.
fn base_from_camera(back: bool) -> Rigid {
    let ahead = pose(0.0, 0.0, 0.0, CAMERA_HEIGHT_M, CAMERA_PITCH_RAD).base_from_camera;
    let turn = DQuat::from_rotation_z(if back { std::f64::consts::PI } else { 0.0 });
    Rigid { rotation: turn * ahead.rotation, ..ahead }
}

fn record_frame(recorder: &mut Recorder, name: &str, back: bool, ms: u64) {
    let (camera, frame) = (small_camera(), format!("{name}_optical"));
    let (width, height) = (camera.width, camera.height);
    let info = CameraInfo {
        header: header(at_ms(ms), &frame),
        width,
        height,
        distortion_model: "plumb_bob".into(),
        d: vec![0.0; 5],
        k: [camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0],
        ..CameraInfo::default()
    };
    recorder.info(&format!("/{name}/depth/camera_info"), at_ms(ms), &info);
    let depth_m = scene().depth(&camera, map_from_base(ms).then(base_from_camera(back)));
    let millimetres = |m: f32| (m * 1000.0).round().clamp(0.0, 65_535.0) as u16;
    let data = depth_m.into_iter().flat_map(|m| millimetres(m).to_le_bytes()).collect();
    let (header, encoding) = (header(at_ms(ms), &frame), "16UC1".into());
    let image = Image { header, height, width, encoding, is_bigendian: 0, step: 2 * width, data };
    recorder.image(&format!("/{name}/depth/image_raw"), at_ms(ms), &image);
}

fn scan(ms: u64) -> Scan {
    let base = map_from_base(ms);
    let yaw = 0.1 * ms as f64 * 1e-3;
    GlassRoom { yaw, sensor_m: base.translation_m, ..GlassRoom::default() }.scan().0
}

fn record_scan(recorder: &mut Recorder, ms: u64) {
    let fields = [
        ("x", FLOAT32, 4),
        ("y", FLOAT32, 4),
        ("z", FLOAT32, 4),
        ("intensity", FLOAT32, 4),
        ("ring", 4, 2),
        ("return_type", 2, 1),
    ];
    let mut data = Vec::new();
    for point in scan(ms).points {
        let [x, y, z] = point.position_m();
        [x, y, z, point.intensity].into_iter().for_each(|value| data.extend(value.to_le_bytes()));
        data.extend(point.ring.to_le_bytes());
        data.push(point.return_type as u8);
    }
    let message: PointCloud2 = cloud(header(at_ms(ms), "lidar"), &fields, data);
    recorder.ros("/points", "sensor_msgs/msg/PointCloud2", at_ms(ms), &message);
}

/// Half a second of the hall: scans, frames of the front camera from the first scan on, and a rear camera that fails.
fn recording() -> Saved {
    let mut recorder = Recorder::new();
    for (name, back) in [("front", false), ("rear", true)] {
        let Rigid { rotation, translation_m } = base_from_camera(back);
        let frames = ["base_link", &format!("{name}_optical")];
        recorder.transform("/tf_static", at_ms(0), frames, translation_m.to_array(), rotation.to_array());
    }
    let lidar_m = [0.0, 0.0, LIDAR_HEIGHT_M];
    recorder.transform("/tf_static", at_ms(0), ["base_link", "lidar"], lidar_m, [0.0, 0.0, 0.0, 1.0]);
    for ms in (0..=600).step_by(10) {
        if ms % 50 == 0 {
            let Rigid { rotation, translation_m } = map_from_base(ms);
            let frames = ["map", "base_link"];
            recorder.transform("/tf", at_ms(ms), frames, translation_m.to_array(), rotation.to_array());
        }
        match ms % 100 {
            0 if ms <= 500 => record_scan(&mut recorder, ms),
            40 => record_frame(&mut recorder, "front", false, ms),
            70 if ms < 200 => record_frame(&mut recorder, "rear", true, ms),
            _ => {}
        }
    }
    recorder.save()
}

struct Run {
    folder: tempfile::TempDir,
    said: String,
}

fn run(recording: &Saved, config: &str) -> Run {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("robot.yaml"), config).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
    command.arg("run").arg(&recording.path).arg("--config").arg(path("robot.yaml"));
    command.arg("-o").arg(path("out.mcap")).arg("--png").arg(path("png")).arg("--dump").arg(path("dump"));
    let output = command.arg("--map").arg(path("map")).output().unwrap();
    let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert!(output.status.success(), "{said}");
    Run { folder, said }
}

impl Run {
    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Messages of a topic, without their encapsulation header.
    fn messages(&self, topic: &str) -> Vec<Vec<u8>> {
        let bytes = self.bytes("out.mcap");
        let messages = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
        messages.filter(|m| m.channel.topic == topic).map(|m| m.data[4..].to_vec()).collect()
    }

    fn last<T: for<'a> Deserialize<'a>>(&self, topic: &str) -> T {
        let messages = self.messages(topic);
        let last = messages.last().unwrap_or_else(|| panic!("no message on {topic}"));
        cdr_encoding::from_bytes::<T, LittleEndian>(last).unwrap().0
    }

    fn map(&self) -> Map {
        let (_, _, (corner_m, _), columns, [cell_m, _], .., data) =
            self.last::<VerdictGrid>("/limpid/verdicts");
        Map { corner_m, columns: columns as usize, cell_m, data }
    }

    /// Files of a folder, sorted.
    fn files(&self, folder: &str) -> Vec<String> {
        files(&self.path(folder))
    }
}

fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

type Time = (i32, u32);
type Header = (Time, String);
type Transform = ([f64; 3], [f64; 4]);
type VerdictGrid = (Time, String, Transform, u32, [f64; 2], u32, u32, Vec<(String, u32, u8)>, ByteBuf);
type Diagnostics = (Header, Vec<(u8, String, String, String, Vec<(String, String)>)>);

/// The last map's verdicts.
struct Map {
    corner_m: [f64; 3],
    columns: usize,
    cell_m: f64,
    data: ByteBuf,
}

/// Cost before inflation, row of the rule, sensor counted from 1.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Said {
    cost: u8,
    reason: u8,
    sensor: u8,
}

impl Map {
    /// The centre of the first cell of that reason.
    fn first(&self, reason: u8) -> Option<[f64; 2]> {
        let index = self.data.chunks_exact(8).position(|cell| cell[1] == reason)?;
        let centre = |cell: usize, axis: usize| self.corner_m[axis] + (cell as f64 + 0.5) * self.cell_m;
        Some([centre(index % self.columns, 0), centre(index / self.columns, 1)])
    }

    fn at(&self, x_m: f64, y_m: f64) -> Said {
        let cell = |m: f64, axis: usize| ((m - self.corner_m[axis]) / self.cell_m).floor() as usize;
        let at = 8 * (cell(y_m, 1) * self.columns + cell(x_m, 0));
        Said { cost: self.data[at], reason: self.data[at + 1], sensor: self.data[at + 2] }
    }

    /// How many of the cells of a rectangle are as wanted, and how many there are.
    fn count(&self, x_m: [f64; 2], y_m: [f64; 2], wanted: impl Fn(Said) -> bool) -> [usize; 2] {
        let centres = |[from, to]: [f64; 2]| {
            let cells = ((to - from) / self.cell_m).round() as usize;
            (0..cells).map(move |i| from + (i as f64 + 0.5) * self.cell_m)
        };
        let all = centres(y_m).flat_map(|y| centres(x_m).map(move |x| (x, y)));
        all.fold([0, 0], |[found, all], (x, y)| [found + usize::from(wanted(self.at(x, y))), all + 1])
    }
}

const OUTSIDE: [[f64; 2]; 2] = [[4.3, 7.9], [-2.0, 2.0]];
const AROUND_MIRRORED: [[f64; 2]; 2] = [[4.8, 5.6], [0.4, 1.2]];

fn by_camera(said: Said) -> bool {
    said.sensor == FRONT || said.sensor == REAR
}

#[test]
fn a_hall_with_glass_two_cameras_and_a_lidar_is_one_map() {
    if skipped() {
        return;
    }
    let recording = recording();
    let first = run(&recording, CONFIG);
    for used in ["front: 6 used, 0 without a pose", "rear: 2 used", "top: 6 used", "top: glass: 1 panes"] {
        assert!(first.said.contains(used), "{used}: {}", first.said);
    }
    let map = first.map();
    let near_x = |x_m: f64| [x_m - 0.2, x_m + 0.2];
    // The pane is glass and lethal, cell after cell, and comes from the lidar.
    for y_m in (-18..=18).map(|i| 0.1 * f64::from(i) + 0.05) {
        let [glass, _] = map.count(near_x(WALL_X_M), [y_m - 0.05, y_m + 0.05], |said| {
            said == Said { cost: 254, reason: 1, sensor: TOP }
        });
        assert!(glass >= 1, "the pane at y = {y_m}");
    }
    // Walls are solid by the lidar, although both cameras see them too.
    for (x_m, y_m, what) in [
        ([-2.5, 3.5], [3.4, 3.6], "left wall"),
        ([-3.9, 3.5], [-3.6, -3.4], "right wall"),
        ([-4.1, -3.9], [-3.0, 1.0], "back wall"),
    ] {
        let [solid, cells] =
            map.count(x_m, y_m, |said| (said.reason, said.cost, said.sensor) == (2, 254, TOP));
        assert!(solid >= cells * 2 / 5, "{what}: {solid} of {cells} cells in two rows");
    }
    // The floor before the glass is free; the low box on it is the camera's.
    let [free, cells] = map.count([1.9, 3.7], [-0.8, 1.2], |said| said.cost == 0);
    assert_eq!(free, cells, "free floor before the glass");
    let [marked, _] =
        map.count([1.0, 1.5], [-0.5, 0.0], |said| said == Said { cost: 254, reason: 6, sensor: FRONT });
    assert!((3..=25).contains(&marked), "{marked} cells of the low box");
    // Behind the pane the camera neither marks nor clears: what it sees mirrored is not there, what the lidar sees there is.
    assert_eq!(map.count(OUTSIDE[0], OUTSIDE[1], by_camera)[0], 0);
    let [there, cells] = map.count(AROUND_MIRRORED[0], AROUND_MIRRORED[1], |said| said.cost == 254);
    assert_eq!(there, 0, "of {cells} cells around what is mirrored");
    assert!(map.count([6.3, 6.5], [-1.6, -0.3], |said| (said.reason, said.sensor) == (2, TOP))[0] >= 8);
}

#[test]
fn control_without_glass_the_camera_marks_what_it_sees_through_the_pane() {
    if skipped() {
        return;
    }
    let blind = run(&recording(), &CONFIG.replace("glass: true", "glass: false"));
    let map = blind.map();
    let [x_m, y_m] = AROUND_MIRRORED;
    let [marked, _] = map.count(x_m, y_m, |said| said == Said { cost: 254, reason: 6, sensor: FRONT });
    assert!(marked >= 3, "{marked} cells of what is mirrored");
    assert_eq!(map.count([-4.0, 7.9], [-3.5, 3.5], |said| said.reason == 1)[0], 0);
}

#[test]
fn the_halls_files_hold_one_map_and_the_states_of_its_sensors_and_the_same_bits_again() {
    if skipped() {
        return;
    }
    let recording = recording();
    let [first, second] = [(); 2].map(|()| run(&recording, CONFIG));
    let maps = first.messages("/limpid/costmap").len();
    assert!((5..=8).contains(&maps), "{maps} maps of 0.57 s at 10 Hz");
    for topic in ["/limpid/costmap_raw", "/limpid/classes", "/limpid/verdicts"] {
        assert_eq!(first.messages(topic).len(), maps, "{topic}");
    }
    let bytes = first.bytes("out.mcap");
    let topics: std::collections::BTreeSet<String> =
        mcap::MessageStream::new(&bytes).unwrap().map(|m| m.unwrap().channel.topic.clone()).collect();
    let grids = ["costmap", "costmap_raw", "classes", "verdicts"].map(|name| format!("/limpid/{name}"));
    assert!(grids.iter().all(|topic| topics.contains(topic)), "{topics:?}");
    assert!(!topics.iter().any(|topic| topic.contains("plan")), "{topics:?}");
    assert!(topics.contains("/limpid/front/reliability") && topics.contains("/limpid/glass/points"));
    // The rear camera failed after 170 ms.
    let (_, status): Diagnostics = first.last("/limpid/diagnostics");
    let said: Vec<_> =
        status.iter().map(|(level, name, message, ..)| (*level, name.as_str(), message)).collect();
    let of =
        |name: &str| said.iter().find(|(_, title, _)| *title == name).unwrap_or_else(|| panic!("{said:?}"));
    assert_eq!(said.len(), 4, "{said:?}");
    assert_eq!(of("limpid: depth reliability: front").0, 0);
    let (level, _, message) = of("limpid: depth reliability: rear");
    assert_eq!((*level, message.as_str()), (1, "STALE: no data for longer than 0.3 s"));
    assert_eq!(of("limpid: lidar").0, 0);
    let (level, _, message) = of("limpid: map");
    assert_eq!((*level, message.as_str()), (1, "STALE: rear"));
    // One map in every other form.
    let last = format!("{:06}", maps - 1);
    assert_eq!(first.files("dump"), ["front", "map", "rear", "top"]);
    let grids =
        ["age_s.exr", "class.exr", "cost.exr", "costmap.exr", "frame.json", "reason.exr", "sensor.exr"];
    assert_eq!(first.files(&format!("dump/map/{last}")), grids);
    let pictures = first.files("png");
    assert_eq!(pictures.iter().filter(|name| name.starts_with("map-")).count(), maps, "{pictures:?}");
    assert_eq!(first.files(".").iter().filter(|name| name.ends_with(".pgm")).count(), 1);
    assert!(first.bytes("map.pgm").starts_with(b"P5\n160 160\n255\n"));
    // The same bits again.
    for topic in topics.iter().filter(|topic| *topic != "/limpid/diagnostics") {
        assert!(first.messages(topic) == second.messages(topic), "{topic}");
    }
    let picture = format!("png/map-{last}-map.png");
    let reasons = format!("dump/map/{last}/reason.exr");
    for name in ["map.pgm", "map.yaml", &picture, &reasons] {
        assert!(first.bytes(name) == second.bytes(name), "{name}");
    }
}
