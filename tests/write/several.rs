//! One file of several sensors: topics, states and the map's verdicts.

use std::collections::BTreeSet;

use limpid::Config;
use limpid::map::glass::{GlassCounters, LabelledScan};
use limpid::map::{Seen, State, Update};
use limpid::output::{McapSink, Sink};
use limpid::sensor::{Observation, SensorData};
use serde_bytes::ByteBuf;

use super::mcap::{Diagnostics, Time, Transform, Transforms, decode, read, write_all};
use crate::support::sample;
use crate::support::scan::scan;

/// What came of a labelled scan of no points, numbered as sensor `sensor`.
fn labelled(sensor: usize) -> (Update, Observation) {
    let mut update = sample::scan_output();
    let Some(Seen::Lidar(lidar)) = &mut update.seen else { panic!("a lidar's") };
    let (classes, panes, pass_ms) = (Vec::new(), Vec::new(), Vec::new());
    lidar.glass = Some(LabelledScan { classes, panes, counters: GlassCounters::default(), pass_ms });
    let data = SensorData::Scan(scan(0, Vec::new()));
    let observation = Observation { sensor, pose: None, map_frame: "map".into(), goal_m: None, data };
    (Update { sensor: Some(sensor), ..update }, observation)
}

/// What came of a frame without a map, numbered as sensor `sensor`.
fn camera_alone(sensor: usize) -> Update {
    Update { sensor: Some(sensor), map: None, ..sample::output() }
}

fn topics(messages: &[super::mcap::Message]) -> BTreeSet<&str> {
    messages.iter().map(|message| message.topic.as_str()).collect()
}

const MAP_TOPICS: [&str; 5] =
    ["/limpid/costmap", "/limpid/costmap_raw", "/limpid/classes", "/limpid/verdicts", "/limpid/diagnostics"];

#[test]
fn a_camera_and_a_lidar_share_a_file_with_one_map() {
    let config = Config::default();
    let sensors = [sample::camera("front", &config), sample::lidar("top", &config)];
    let (scan, observed) = labelled(1);
    let scan = Update { map: None, ..scan };
    let results =
        [(&camera_alone(0), Some(&sample::input())), (&scan, Some(&observed)), (&sample::published(), None)];
    let (_folder, path) = write_all(&config, &sensors, &results);
    let messages = read(&path);
    let own = [
        "/limpid/depth_filtered/camera_info",
        "/limpid/depth_filtered/image",
        "/limpid/glass/cleaned",
        "/limpid/glass/panes",
        "/limpid/glass/points",
        "/limpid/points_trusted",
        "/limpid/reliability",
        "/limpid/reliability_float",
        "/tf",
    ];
    let expected: BTreeSet<_> = MAP_TOPICS.into_iter().chain(own).collect();
    assert_eq!(topics(&messages), expected, "one camera and one lidar need no names");
    let maps = messages.iter().filter(|m| m.topic == "/limpid/costmap").count();
    assert_eq!(maps, 1, "results without a map write none");
    let lidar = messages.iter().filter(|m| m.topic == "/tf").nth(1).unwrap();
    let transforms: Transforms = decode(std::slice::from_ref(lidar), "/tf");
    assert_eq!(transforms.iter().map(|t| t.1.as_str()).collect::<Vec<_>>(), ["base_link", "lidar"]);
}

#[test]
fn of_two_cameras_each_has_topics_and_frames_of_its_own_name() {
    let config = Config::default();
    let still = Config { cloud_stride: 0, ..Config::default() };
    let sensors =
        [sample::camera("front", &config), sample::camera("rear", &still), sample::lidar("top", &config)];
    let mut nameless = sample::frame(sample::millimetres());
    nameless.depth.frame_id = String::new();
    let nameless = sample::observed(nameless);
    let (scan, observed) = labelled(2);
    let results =
        [(&camera_alone(0), Some(&nameless)), (&camera_alone(1), Some(&nameless)), (&scan, Some(&observed))];
    let (_folder, path) = write_all(&config, &sensors, &results);
    let messages = read(&path);
    let found = topics(&messages);
    let images = ["reliability", "reliability_float", "depth_filtered/image", "depth_filtered/camera_info"];
    for name in images {
        assert!(found.contains(format!("/limpid/front/{name}").as_str()), "{name}: {found:?}");
        assert!(found.contains(format!("/limpid/rear/{name}").as_str()), "{name}: {found:?}");
        assert!(!found.contains(format!("/limpid/{name}").as_str()), "{name}: {found:?}");
    }
    assert!(found.contains("/limpid/front/points_trusted"));
    assert!(!found.contains("/limpid/rear/points_trusted"), "by its own cloud_stride");
    assert!(found.contains("/limpid/glass/points"), "the only lidar");
    let frames: Vec<_> = messages
        .iter()
        .filter(|message| message.topic == "/tf")
        .map(|message| decode::<Transforms>(std::slice::from_ref(message), "/tf")[1].1.clone())
        .collect();
    assert_eq!(frames, ["front_optical_frame", "rear_optical_frame", "lidar"]);
}

type VerdictGrid = (Time, String, Transform, u32, [f64; 2], u32, u32, Vec<(String, u32, u8)>, ByteBuf);

#[test]
fn verdicts_are_a_grid_with_four_fields() {
    let config = Config::default();
    let sensors = [sample::camera("front", &config), sample::lidar("top", &config)];
    let update = sample::published();
    let (_folder, path) = write_all(&config, &sensors, &[(&update, None)]);
    let messages = read(&path);
    let message = messages.iter().find(|m| m.topic == "/limpid/verdicts").unwrap();
    assert_eq!(
        (message.schema_name.as_str(), message.log_time),
        ("foxglove_msgs/msg/Grid", sample::STAMP_NS)
    );
    let (stamp, frame_id, corner, columns, cell_size_m, row_stride, cell_stride, fields, data) =
        decode::<VerdictGrid>(&messages, "/limpid/verdicts");
    assert_eq!((stamp, frame_id.as_str()), ((1_700_000_001, 234_567_890), "map"));
    assert_eq!(corner, ([1.05, -2.45, 0.0], [0.0, 0.0, 0.0, 1.0]));
    assert_eq!((columns, cell_size_m), (16, [0.05, 0.05]));
    // The schema numbers the types.
    let schema = std::str::from_utf8(&message.schema).unwrap();
    assert!(schema.contains("uint8 UINT8=1\n") && schema.contains("uint8 FLOAT32=7\n"), "{schema}");
    let expected = [("cost", 0, 1), ("reason", 1, 1), ("sensor", 2, 1), ("age_s", 4, 7)];
    assert_eq!(fields, expected.map(|(name, offset, number)| (name.to_owned(), offset, number)));
    assert_eq!((cell_stride, row_stride, data.len()), (8, 128, 8 * 272));
    let cells: Vec<_> = data.chunks_exact(8).collect();
    let age_s = |cell: &[u8]| f32::from_le_bytes([cell[4], cell[5], cell[6], cell[7]]);
    assert_eq!((&cells[0][..3], age_s(cells[0])), (&[254, 1, 2][..], 2.5));
    assert_eq!((&cells[6][..3], age_s(cells[6])), (&[50, 7, 2][..], 2.5));
    assert_eq!((&cells[20][..3], age_s(cells[20])), (&[0, 8, 2][..], 0.3_f32));
}

#[test]
fn diagnostics_say_the_state_of_every_sensor_and_of_the_map() {
    let config = Config::default();
    let sensors =
        [sample::camera("front", &config), sample::camera("rear", &config), sample::lidar("top", &config)];
    let with_states = |states: [State; 3]| {
        let mut update = sample::published();
        let map = update.map.as_mut().unwrap();
        (map.state, map.sensors) = (states.into_iter().max().unwrap(), states.to_vec());
        update
    };
    let results = [
        (&camera_alone(0), Some(&sample::input())),
        (&with_states([State::Ok, State::Stale, State::Fault]), None),
        (&with_states([State::Stale, State::Degraded, State::Ok]), None),
    ];
    let (_folder, path) = write_all(&config, &sensors, &results);
    let arrays: Vec<Diagnostics> = read(&path)
        .iter()
        .filter(|message| message.topic == "/limpid/diagnostics")
        .map(|message| decode(std::slice::from_ref(message), "/limpid/diagnostics"))
        .collect();
    let said = |at: usize| -> Vec<(u8, &str, &str)> {
        arrays[at]
            .1
            .iter()
            .map(|(level, name, message, ..)| (*level, name.as_str(), message.as_str()))
            .collect()
    };
    let ok = "OK: 50 % of the depth pixels are unreliable";
    let [front, rear] = ["front", "rear"].map(|name| format!("limpid: depth reliability: {name}"));
    assert_eq!(said(0), [(0, front.as_str(), ok)], "without a map only of itself");
    let expected = [
        (0, front.as_str(), ok),
        (1, rear.as_str(), "STALE: no data so far"),
        (2, "limpid: lidar", "FAULT: it cannot be used any more"),
        (2, "limpid: map", "FAULT: top"),
    ];
    assert_eq!(said(1), expected);
    let expected = [
        (1, front.as_str(), "STALE: no data for longer than 0.5 s"),
        (1, rear.as_str(), "DEGRADED"),
        (0, "limpid: lidar", "OK"),
        (1, "limpid: map", "STALE: front"),
    ];
    assert_eq!(said(2), expected);
}

#[test]
fn results_that_do_not_fit_the_sensors_are_refused() {
    let config = Config::default();
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("out.mcap");
    let mut sink = McapSink::create(&path, &config, &sample::alone()).unwrap();
    let mut refused = |update: &Update, observation: Option<&Observation>| {
        sink.write(update, observation).unwrap_err().to_string()
    };
    let (scan, observed) = labelled(0);
    assert!(refused(&camera_alone(1), Some(&sample::input())).contains("sensor 1, and there are 1 sensors"));
    assert!(refused(&camera_alone(0), None).contains("without its observation"));
    assert!(refused(&scan, Some(&sample::input())).contains("a lidar's of a frame"));
    assert!(refused(&camera_alone(0), Some(&observed)).contains("a camera's result of a scan"));
}

#[test]
fn a_killed_run_of_a_lidar_leaves_the_maps_that_were_flushed() {
    let config = Config::default();
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("out.mcap");
    let mut sink = McapSink::create(&path, &config, &[sample::lidar("lidar", &config)]).unwrap();
    let (scan, observed) = labelled(0);
    for _ in 0..40 {
        sink.write(&scan, Some(&observed)).unwrap();
    }
    let readable = super::mcap::readable(&folder.path().join("out.partial.mcap"), "/limpid/classes");
    assert!((26..40).contains(&readable), "{readable} of 40 scans");
    sink.finish().unwrap();
}
