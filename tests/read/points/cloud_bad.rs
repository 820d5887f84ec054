//! Clouds that are refused by name, and points that are left out by reason.

use limpid::message::ros2::PointCloud2;
use limpid::sensor::{DropReason, Point};

use super::cloud::read;
use super::make::{XYZI, cloud, xyzi};
use super::{read_bytes, refused};
use crate::read::synthetic::{Recorder, at_ms};

const CLOUD: &str = "sensor_msgs/msg/PointCloud2";

#[track_caller]
fn wrong(change: impl FnOnce(&mut PointCloud2), parts: &[&str]) {
    let mut message = xyzi(&[[1.0; 4]; 6]);
    change(&mut message);
    refused(read(message), &[&["sensor_msgs/PointCloud2"], parts].concat());
}

#[test]
fn clouds_without_a_needed_field_are_refused() {
    for (at, name) in ["x", "y", "z"].iter().enumerate() {
        wrong(|message| drop(message.fields.remove(at)), &[&format!("no field `{name}`"), "its fields: "]);
    }
    wrong(|message| message.fields.clear(), &["no field `x`", "there are none"]);
}

#[test]
fn steps_and_sizes_must_fit() {
    wrong(|message| message.point_step = 0, &["point_step is 0"]);
    wrong(|message| message.row_step = 0, &["row_step 0 is less than 6 points of 16 bytes"]);
    wrong(|message| message.row_step = 95, &["row_step 95"]);
    wrong(|message| message.row_step = 97, &["1 rows of 97 bytes do not fit 96"]);
    wrong(|message| message.data.truncate(95), &["95 bytes of data"]);
    wrong(|message| message.height = 2, &["2 rows of 96 bytes"]);
    let huge = |message: &mut PointCloud2| {
        (message.height, message.width, message.point_step) = (u32::MAX, u32::MAX, u32::MAX);
        message.row_step = u32::MAX;
    };
    wrong(huge, &["row_step"]);
    wrong(|message| message.width = u32::MAX, &["row_step"]);
    wrong(|message| message.height = u32::MAX, &["4294967295 rows"]);
}

#[test]
fn fields_must_lie_apart_and_within_the_point() {
    wrong(
        |message| message.fields[3].offset = 13,
        &["field `intensity` at offset 13", "past the point's 16 bytes"],
    );
    wrong(|message| message.fields[0].offset = u32::MAX, &["field `x`", "past"]);
    wrong(|message| message.fields[3].datatype = 8, &["field `intensity`", "past"]);
    wrong(|message| message.fields[1].offset = 3, &["fields `x` and `y` overlap"]);
    wrong(|message| message.fields[3].offset = 8, &["`z` and `intensity` overlap"]);
    wrong(|message| message.fields[2].name = "X".into(), &["no field `z`"]);
    let twice = |message: &mut PointCloud2| {
        let again = message.fields[0].clone();
        message.fields.push(again);
    };
    wrong(twice, &["field `x` twice"]);
    wrong(|message| message.fields[1].datatype = 9, &["field `y` is of type 9"]);
    let mut early = xyzi(&[[1.0; 4]]);
    early.header.stamp.sec = -1;
    refused(read(early), &["stamp", "out of range"]);
}

#[test]
fn points_that_cannot_be_are_dropped_and_counted() {
    let points = [
        [1.0, 2.0, 3.0, 4.0],
        [f32::NAN, 2.0, 3.0, 4.0],
        [1.0, f32::INFINITY, 3.0, 4.0],
        [1.0, 2.0, f32::NEG_INFINITY, 4.0],
        [1.0, 2.0, 3.0, f32::NAN],
        [0.0, -0.0, 0.0, 4.0],
        [0.0, 0.0, 1e-3, 0.0],
    ];
    let scan = read(xyzi(&points)).unwrap();
    assert_eq!(scan.points.len(), 2);
    assert_eq!(
        scan.dropped.reasons().collect::<Vec<_>>(),
        [(DropReason::NoReturn, 1), (DropReason::NotFinite, 4)]
    );
    assert_eq!(scan.dropped.total(), 5);
    // Coordinates beyond what 32 bits hold are infinite in them.
    let data: Vec<u8> = [1e300_f64, 1.0, 1.0, 1.0].iter().flat_map(|value| value.to_le_bytes()).collect();
    let far = cloud(&[("x", 0, 8), ("y", 8, 8), ("z", 16, 8), ("i", 24, 8)], 32, 1, data);
    assert_eq!(read(far).unwrap().dropped.count(DropReason::NotFinite), 1);
}

#[test]
fn points_keep_their_places_without_rings_and_labels_that_are_no_whole_numbers() {
    for name in ["ring", "label"] {
        let fields = [XYZI, &[(name, 16, 8)]].concat();
        let values = [0.0, 17.0, -1.0, 2.5, f64::NAN, 1e10];
        let point = |value: f64| [&[0, 0, 128, 63].repeat(4), &value.to_le_bytes()[..]].concat();
        let scan = read(cloud(&fields, 24, 6, values.map(point).concat())).unwrap();
        assert_eq!((scan.points.len(), scan.dropped.total()), (6, 0), "{name}");
        let known = |point: &&Point| match name {
            "ring" => point.ring != Point::UNKNOWN,
            _ => point.label != Point::UNLABELLED,
        };
        assert_eq!(scan.points.iter().filter(known).count(), 2, "{name}");
    }
}

#[test]
fn no_points_and_a_million() {
    let scan = read(xyzi(&[])).unwrap();
    assert!(scan.points.is_empty() && scan.dropped.total() == 0);
    let mut rows = xyzi(&[]);
    rows.height = u32::MAX;
    assert!(read(rows).unwrap().points.is_empty(), "any number of empty rows");
    let million: Vec<[f32; 4]> = (1..=1_000_000).map(|at| [at as f32, 0.0, 0.0, 1.0]).collect();
    let scan = read(xyzi(&million)).unwrap();
    assert_eq!(scan.points.len(), 1_000_000);
    assert_eq!(scan.points.iter().map(|point| f64::from(point.x_m)).sum::<f64>(), 500_000_500_000.0);
}

#[test]
fn bad_messages_are_counted_and_the_others_read() {
    let mut recorder = Recorder::new();
    let mut send = |ms: u64, message: &PointCloud2| recorder.ros("/points", CLOUD, at_ms(ms), message);
    send(0, &xyzi(&[[1.0; 4]]));
    send(1, &xyzi(&[]));
    send(2, &xyzi(&[[f32::NAN; 4]; 3]));
    let mut without = xyzi(&[[1.0; 4]]);
    without.fields.truncate(2);
    send(3, &without);
    send(4, &xyzi(&[[2.0; 4]; 2]));
    recorder.bytes("/points", CLOUD, "cdr", at_ms(5), &[0, 1, 0, 0, 9, 9]);
    let (scans, report) = read_bytes("bad.mcap", &recorder.finish()).unwrap();
    assert_eq!(
        scans.iter().map(|scan| (scan.index, scan.points.len())).collect::<Vec<_>>(),
        [(0, 1), (1, 2)]
    );
    assert_eq!((report.scans, report.points, report.dropped.count(DropReason::NotFinite)), (2, 3, 3));
    let skipped: Vec<(&str, u64)> =
        report.read.skipped.iter().map(|skip| (skip.reason.as_str(), skip.count)).collect();
    assert_eq!(skipped.len(), 3, "{skipped:?}");
    assert_eq!(skipped[0], ("the cloud has no points", 2));
    assert!(skipped[1].0.contains("no field `z`") && skipped[2].1 == 1, "{skipped:?}");
    assert!(report.read.skipped.iter().all(|skip| skip.source == "/points"));
}
