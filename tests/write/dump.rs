//! EXR dumps read back with the exr crate's general reader, and their JSON.

use std::path::Path;

use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};
use limpid::Config;
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
    let mut sink = DumpSink::create(&folder.path().join("dump"), &Config::default()).unwrap();
    sink.write(&sample::input(sample::millimetres()), &sample::output()).unwrap();
    sink.finish().unwrap();
    folder
}

#[test]
fn buffers_have_their_values_and_orientation() {
    let folder = dump();
    let frame = folder.path().join("dump/000012");
    let output = sample::output();
    let (images, layers) = (output.images.unwrap(), output.layers.unwrap());
    let costs: Vec<_> = output.costmap.iter().map(|&cost| f32::from(cost)).collect();
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
        "map_from_base": pose(output.map_from_base),
        "base_from_camera": pose(output.base_from_camera),
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

#[test]
fn without_read_back_only_costmap_and_json() {
    let folder = TempDir::new().unwrap();
    let mut sink = DumpSink::create(folder.path(), &Config::default()).unwrap();
    let output =
        limpid::frame::FrameOutput { images: None, layers: None, degraded: true, ..sample::output() };
    sink.write(&sample::input(sample::millimetres()), &output).unwrap();
    let frame = folder.path().join("000012");
    let mut names: Vec<_> =
        std::fs::read_dir(&frame).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    assert_eq!(names, ["costmap.exr", "frame.json"]);
    let text = std::fs::read_to_string(frame.join("frame.json")).unwrap();
    assert!(text.contains("\"state\": \"DEGRADED\""), "{text}");
}
