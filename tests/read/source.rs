//! Sources of one sensor: the frames, scans and poses that the readers of one sensor gave before there were sources.

use std::collections::BTreeMap;
use std::path::Path;

use limpid::Config;
use limpid::config::{SensorConfig, SensorKind};
use limpid::input::{PosedScans, SourceReport, open, open_source};
use limpid::message::ros2::CameraInfo;
use limpid::sensor::SensorModel;
use limpid::sensor::{DropReason, Dropped, Observation, RgbdFrame, SensorData};

use super::synthetic::{DEPTH, DEPTH_INFO, FRAME, Recorder, at_ms, camera_info, depth_image};
use crate::support::{data_dir, data_path};

/// All observations of a recording and what its source reported.
pub(super) fn read_source(path: &Path, config: &Config) -> (Vec<Observation>, SourceReport) {
    let mut source = open_source(path, config).unwrap();
    let observations = std::iter::from_fn(|| source.next().unwrap()).collect();
    (observations, source.report())
}

/// FNV-1a, which does not change between versions of the language.
fn digest(text: &str) -> String {
    let hash = text
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3));
    format!("{hash:#018x}")
}

/// Of all fields of a frame or a scan and of its pose.
fn digest_of(observation: &Observation) -> String {
    let Observation { pose, map_frame, goal_m, data, .. } = observation;
    match data {
        SensorData::Frame(frame) => {
            // Words, which may be put better.
            let frame = RgbdFrame { color_missing: None, ..(**frame).clone() };
            digest(&format!("{frame:?}").replace("color_missing: None, ", ""))
        }
        SensorData::Scan(scan) => {
            let pose = pose.map(|pose| (pose.map_from_base, pose.base_from_sensor, pose.sweep));
            let dropped = scan.dropped;
            // As scans were before they told of absent intensities and of clocks.
            let scan = format!("{scan:?}").replace("Columns { intensity: true, ", "Columns { ");
            let scan = scan.replace(", clock: Stamp", "").replace(&format!("{dropped:?}"), &counted(dropped));
            digest(&format!("{scan} {map_frame:?} {pose:?} {goal_m:?}"))
        }
    }
}

/// Points left out as they were counted before those without whole rings and labels kept their places.
fn counted(dropped: Dropped) -> String {
    let [no_return, not_finite, code] = [DropReason::NoReturn, DropReason::NotFinite, DropReason::ReturnCode]
        .map(|reason| dropped.count(reason));
    format!("Dropped {{ counts: [{no_return}, {not_finite}, 0, {code}, 0] }}")
}

fn stored_digests() -> BTreeMap<String, Vec<String>> {
    let text = std::fs::read_to_string("testdata/reference/source_digests.json").unwrap();
    serde_json::from_str(&text).unwrap()
}

#[test]
fn single_sensors_give_what_their_readers_gave() {
    let stored = stored_digests();
    assert!(stored.len() > 20);
    let (mut compared, mut different) = (0, BTreeMap::new());
    for (name, expected) in stored {
        let is_own = name.starts_with("testdata");
        let path = if is_own { Some(name.clone().into()) } else { data_dir(&name) };
        let Some(path) = path else { continue };
        let mut source = open_source(&path, &Config::default()).unwrap();
        assert_eq!(source.sensors().len(), 1, "{name}");
        let first = std::iter::from_fn(|| source.next().unwrap()).take(5);
        let found: Vec<String> = first.map(|o| digest_of(&o)).collect();
        if found != expected {
            different.insert(name, found);
        }
        compared += 1;
    }
    assert!(different.is_empty(), "{different:#?}");
    assert!(compared > 0);
}

#[test]
fn a_camera_none_of_whose_images_can_be_used_is_an_error() {
    let mut recorder = Recorder::new();
    for ms in [0, 33] {
        let info = CameraInfo { k: [0.0; 9], ..camera_info(at_ms(ms), FRAME) };
        recorder.info(DEPTH_INFO, at_ms(ms), &info);
        recorder.image(DEPTH, at_ms(ms), &depth_image(at_ms(ms), 700));
    }
    let error = open_source(&recorder.save().path, &Config::default()).err().unwrap().to_string();
    assert!(error.contains("none of its 2 depth images can be used") && error.contains("fx = 0"), "{error}");
}

#[test]
fn a_digest_tells_poses_apart() {
    let mut source = open_source(Path::new("testdata/room.mcap"), &Config::default()).unwrap();
    let first = source.next().unwrap().unwrap();
    let SensorData::Frame(mut frame) = first.data.clone() else { panic!("a camera") };
    frame.pose.as_mut().unwrap().map_from_base.translation_m.x += 1e-12;
    let moved = Observation { data: SensorData::Frame(frame), ..first.clone() };
    assert_ne!(digest_of(&first), digest_of(&moved));
}

#[test]
fn the_pose_of_a_frame_is_that_of_its_observation() {
    let config = Config::default();
    let (observations, report) = read_source(Path::new("testdata/room.mcap"), &config);
    let mut recording = open(Path::new("testdata/room.mcap"), &config).unwrap();
    for observation in &observations {
        let frame = recording.next_frame().unwrap().unwrap();
        assert_eq!(observation.frame(), Some(&frame));
        let pose = observation.pose.unwrap();
        let expected = frame.pose.unwrap();
        assert_eq!(
            (pose.map_from_base, pose.base_from_sensor),
            (expected.map_from_base, expected.base_from_camera)
        );
        assert_eq!(observation.map_frame, "map");
    }
    assert_eq!(recording.next_frame().unwrap(), None);
    let counted = &report.sensors[0];
    assert_eq!((counted.name.as_str(), counted.seen, counted.given), ("camera", 30, 30));
    assert_eq!((counted.without_pose, counted.unusable, counted.late, counted.jumps), (0, 0, 0, 0));
    assert_eq!(report.read, *recording.report());
}

#[test]
fn a_lidar_s_scans_are_counted_as_its_reader_does() {
    let Some(path) = data_dir("lidar/vlp16-dual.mcap") else { return };
    let (observations, report) = read_source(&path, &Config::default());
    let mut scans = PosedScans::open(&path, &Config::default()).unwrap();
    let frames: Vec<_> = std::iter::from_fn(|| scans.next_observation().unwrap()).collect();
    assert_eq!(observations.len(), frames.len());
    assert!(observations.iter().zip(&frames).all(|(o, frame)| o.scan() == frame.scan()));
    let (counted, expected) = (&report.sensors[0], scans.report());
    assert_eq!(
        (counted.seen, counted.points, counted.dropped),
        (expected.scans, expected.points, expected.dropped)
    );
    assert_eq!(report.read, expected.read);
}

#[test]
fn the_first_observations_say_what_a_sensor_is() {
    let source = open_source(Path::new("testdata/room.mcap"), &Config::default()).unwrap();
    let [info] = source.sensors() else { panic!("one sensor") };
    let SensorModel::Camera(camera) = &info.model else { panic!("{:?}", info.model) };
    assert_eq!((info.name.as_str(), info.timeout_s), ("camera", 0.5));
    assert!(!camera.confidence && camera.depth.width > 0 && !info.frame_id.is_empty());
    assert_eq!(source.count_hint(), Some(30));
    let path = data_path("lidar/vlp16-dual.mcap");
    if path.exists() {
        let mut source = open_source(&path, &Config::default()).unwrap();
        let SensorModel::Lidar(lidar) = source.sensors()[0].model.clone() else { panic!("a lidar") };
        assert_eq!(source.next().unwrap().unwrap().scan(), Some(&lidar.first));
    }
}

#[test]
fn the_first_colour_is_looked_for_among_eight_depth_images() {
    for (at, is_found) in [(7, true), (8, false)] {
        let mut recorder = Recorder::new();
        recorder.transform(
            "/tf_static",
            at_ms(0),
            ["map", super::synthetic::FRAME],
            [0.0; 3],
            [0.0, 0.0, 0.0, 1.0],
        );
        for i in 0..12 {
            recorder.depth(at_ms(100 * i), 7);
            if i >= at {
                recorder.color(at_ms(100 * i), 1);
            }
        }
        let saved = recorder.save();
        let mut source = open_source(&saved.path, &Config::default()).unwrap();
        let SensorModel::Camera(camera) = source.sensors()[0].model.clone() else { panic!("a camera") };
        assert_eq!((camera.color.is_some(), camera.color_aligned), (is_found, is_found), "{at}");
        let stamps = std::iter::from_fn(|| source.next().unwrap()).map(|o| o.stamp_ns());
        assert_eq!(stamps.collect::<Vec<_>>(), (0..12).map(|i| at_ms(100 * i)).collect::<Vec<_>>());
    }
}

#[test]
fn a_folder_is_the_first_configured_sensor_of_its_kind() {
    let Some(path) = data_dir("lidar/3dref-hesai-qt64-dual") else { return };
    let sensor = |name: &str, kind| SensorConfig {
        name: name.into(),
        kind,
        timeout_s: 0.25,
        parameters: Config { lidar_frame: "roof".into(), ..Config::default() },
    };
    let sensors = vec![sensor("front", SensorKind::Camera), sensor("top", SensorKind::Lidar)];
    let mut source = open_source(&path, &Config { sensors: sensors.clone(), ..Config::default() }).unwrap();
    let first = source.next().unwrap().unwrap();
    assert_eq!((first.sensor, first.map_frame.as_str()), (1, "roof"));
    let infos = source.sensors();
    assert_eq!(infos[0].model, SensorModel::Missing(SensorKind::Camera));
    assert!(matches!(infos[1].model, SensorModel::Lidar(_)) && infos[1].timeout_s == 0.25);
    assert_eq!(source.report().sensors[1].given, 1);
    let config = Config { sensors: sensors[..1].to_vec(), ..Config::default() };
    let error = open_source(&path, &config).err().unwrap().to_string();
    assert!(error.contains("`sensors`") && error.contains("no lidar"), "{error}");
}
