//! EXR dumps read back with the exr crate's general reader, and their JSON.

use std::path::Path;

use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};
use limpid::Config;
use limpid::map::{ScanLayers, Seen, State};
use limpid::output::{DumpSink, Sink};
use tempfile::TempDir;

use crate::support::sample;

/// Size and samples of the only channel of the only layer, which must be called `Y`.
fn read_exr(path: &Path) -> ((usize, usize), Vec<f32>) {
    let image = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    let image = image.from_file(path).unwrap();
    assert_eq!(image.layer_data.len(), 1);
    let layer = &image.layer_data[0];
    assert_eq!(layer.channel_data.list.len(), 1);
    let channel = &layer.channel_data.list[0];
    assert_eq!(channel.name, *"Y");
    let FlatSamples::F32(samples) = &channel.sample_data else { panic!("not 32-bit floats") };
    ((layer.size.0, layer.size.1), samples.clone())
}

fn dump() -> TempDir {
    let folder = TempDir::new().unwrap();
    let folder_of = folder.path().join("dump");
    let mut sink = DumpSink::create(&folder_of, &Config::default(), &sample::alone()).unwrap();
    sink.write(&sample::output(), Some(&sample::input())).unwrap();
    sink.finish().unwrap();
    folder
}

#[test]
fn buffers_have_their_values_and_orientation() {
    let folder = dump();
    let frame = folder.path().join("dump/000012");
    let output = sample::output();
    let camera = output.camera().unwrap();
    let (images, layers) = (camera.images.as_ref().unwrap(), camera.layers.as_ref().unwrap());
    let costs: Vec<_> = output.map.as_ref().unwrap().costmap.iter().map(|&cost| f32::from(cost)).collect();
    for (name, size, samples) in [
        ("depth_m", (3, 2), &images.depth_m),
        ("reliability", (3, 2), &images.reliability),
        ("evidence", (16, 17), &layers.evidence),
        ("occupancy", (16, 17), &layers.occupancy),
        ("occupied", (16, 17), &layers.occupied),
        ("costmap", (16, 17), &costs),
    ] {
        let found = read_exr(&frame.join(format!("{name}.exr")));
        assert_eq!(found, (size, samples.clone()), "{name}");
    }
}

#[test]
fn frame_json_has_every_figure() {
    let folder = dump();
    let text = std::fs::read_to_string(folder.path().join("dump/000012/frame.json")).unwrap();
    let found: serde_json::Value = serde_json::from_str(&text).unwrap();
    let output = sample::output();
    let pose = |rigid: limpid::base::Rigid| {
        serde_json::json!({
            "translation_m": rigid.translation_m.to_array(),
            "rotation_xyzw": rigid.rotation.to_array(),
        })
    };
    let expected = serde_json::json!({
        "stamp_ns": 1_700_000_001_234_567_890_u64,
        "map_frame": "map",
        "map_from_base": pose(output.map_from_base),
        "base_from_camera": pose(output.base_from_sensor),
        "origin_x_m": 1.05, "origin_y_m": -2.45, "resolution_m": 0.05, "width": 16, "height": 17,
        "state": "OK",
        "low_reliability_fraction": 0.5,
        "counters": {
            "pixels": 6, "valid": 4, "low_reliability": 3, "hits": 2, "hit_cells": 0,
            "seen_through_cells": 0, "occupied_cells": 0, "free_cells": 0,
        },
        "pass_ms": { "ingest": 0.625, "fuse": 0.25 },
    });
    // Through text as well: serde_json's reader may round the last bit of a float.
    let expected: serde_json::Value = serde_json::from_str(&expected.to_string()).unwrap();
    assert_eq!(found, expected);
}

/// Names in a folder, in order.
fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

fn json(folder: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(folder.join("frame.json")).unwrap()).unwrap()
}

#[test]
fn without_read_back_only_costmap_and_json() {
    let folder = TempDir::new().unwrap();
    let mut sink = DumpSink::create(folder.path(), &Config::default(), &sample::alone()).unwrap();
    let mut output = sample::with_camera(|camera| {
        (camera.images, camera.layers, camera.degraded) = (None, None, true);
    });
    output.map.as_mut().unwrap().state = State::Degraded;
    sink.write(&output, Some(&sample::input())).unwrap();
    let frame = folder.path().join("000012");
    assert_eq!(names(&frame), ["costmap.exr", "frame.json"]);
    let text = std::fs::read_to_string(frame.join("frame.json")).unwrap();
    assert!(text.contains("\"state\": \"DEGRADED\""), "{text}");
}

#[test]
fn a_lidar_alone_has_its_map_and_layers_in_one_folder() {
    let folder = TempDir::new().unwrap();
    let config = Config::default();
    let mut sink = DumpSink::create(folder.path(), &config, &[sample::lidar("lidar", &config)]).unwrap();
    let mut output = sample::scan_output();
    let Some(Seen::Lidar(lidar)) = &mut output.seen else { panic!("a lidar's") };
    lidar.layers = Some(ScanLayers { grids: vec![("plan".into(), vec![0.5; 272])] });
    sink.write(&output, None).unwrap();
    let scan = folder.path().join("000012");
    assert_eq!(names(&scan), ["class.exr", "costmap.exr", "frame.json", "plan.exr"]);
    assert_eq!(read_exr(&scan.join("class.exr")), ((16, 17), vec![1.0; 272]));
    assert_eq!(read_exr(&scan.join("plan.exr")), ((16, 17), vec![0.5; 272]));
    let json = json(&scan);
    assert_eq!((json["points"].as_u64(), json["cells"]["free"].as_u64()), (Some(0), Some(272)));
    assert!(json["base_from_lidar"].is_object() && json["base_from_camera"].is_null());
    assert!(json["counters"].is_null(), "a camera's");
}

#[test]
fn several_sensors_and_their_map_have_a_folder_each() {
    let folder = TempDir::new().unwrap();
    let config = Config::default();
    let sensors = [sample::camera("front", &config), sample::lidar("top", &config)];
    let mut sink = DumpSink::create(folder.path(), &config, &sensors).unwrap();
    let mut seen = sample::output();
    seen.map = None;
    let Some(Seen::Camera(camera)) = &mut seen.seen else { panic!("a camera's") };
    // Without a map nothing else says how wide the layers are; windows are square.
    let layers = camera.layers.as_mut().unwrap();
    for layer in [&mut layers.evidence, &mut layers.occupancy, &mut layers.occupied] {
        layer.truncate(256);
    }
    sink.write(&seen, Some(&sample::input())).unwrap();
    sink.write(&sample::published(), None).unwrap();
    assert_eq!(names(folder.path()), ["front", "map"]);
    let front = folder.path().join("front/000012");
    assert_eq!(read_exr(&front.join("evidence.exr")).0, (16, 16));
    assert!(!front.join("costmap.exr").exists());
    assert!(json(&front)["origin_x_m"].is_null() && json(&front)["state"] == "OK");
    let map = folder.path().join("map/000003");
    assert_eq!(json(&map)["state"], "STALE");
    assert!(json(&map)["base_from_camera"].is_null());
    let expected =
        ["age_s.exr", "class.exr", "cost.exr", "costmap.exr", "frame.json", "reason.exr", "sensor.exr"];
    assert_eq!(names(&map), expected);
    let first = |name: &str| read_exr(&map.join(format!("{name}.exr"))).1[0];
    assert_eq!(["cost", "reason", "sensor", "age_s"].map(first), [254.0, 1.0, 2.0, 2.5]);
    let reasons = read_exr(&map.join("reason.exr")).1;
    assert_eq!(reasons[..12], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 8.0]);
}
