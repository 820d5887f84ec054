//! Clouds of any layout, in messages of ROS and Foxglove.

use limpid::input::points::Options;
use limpid::input::points::cloud::{from_foxglove, from_old, from_ros};
use limpid::message::foxglove;
use limpid::message::foxglove::PackedElementField;
use limpid::message::foxglove::packed_element_field::NumericType;
use limpid::message::lidar::{ChannelFloat32, Point32, PointCloud};
use limpid::message::ros2::{Header, PointCloud2};
use limpid::sensor::{DropReason, Point, ReturnCodes, ReturnType, Scan, Strength};

use super::make::{Fields, XYZI, cloud, xyzi};
use super::{read_bytes, read_with, refused};
use crate::read::ros1::{Bag, Compression, header, sized, u32s};
use crate::read::synthetic::{Recorder, at_ms};

const CLOUD: &str = "sensor_msgs/msg/PointCloud2";

pub(super) fn read(message: PointCloud2) -> limpid::Result<Scan> {
    from_ros(message, &Options::default())
}

/// In November 2023.
const STAMP_NS: u64 = 1_700_000_000_000_000_000;

/// One point of x 1, y 2, z 3, intensity 4 and a further field of a 32-byte point.
fn with_field(name: &str, datatype: u8, value: &[u8]) -> Scan {
    let fields = [XYZI, &[(name, 16, datatype)]].concat();
    let mut data: Vec<u8> = [1.0_f32, 2.0, 3.0, 4.0].iter().flat_map(|value| value.to_le_bytes()).collect();
    data.extend(value);
    data.resize(32, 0xaa);
    let mut message = cloud(&fields, 32, 1, data);
    message.header = Header::new(STAMP_NS, "lidar");
    read(message).unwrap()
}

#[test]
fn every_type_padding_and_byte_order_is_read() {
    // i16, u16, i8 and f64 at odd offsets, in a point of 20 bytes of which three are padding.
    let fields: Fields = &[("X", 1, 3), ("y", 3, 4), ("z", 5, 1), ("reflectivity", 6, 8), ("ring", 14, 2)];
    for big_endian in [false, true] {
        let order = |le: Vec<u8>| if big_endian { le.into_iter().rev().collect() } else { le };
        let point = |x: i16, y: u16, z: i8, intensity: f64, ring: u8| {
            let parts = [
                vec![0xee],
                order(x.to_le_bytes().into()),
                order(y.to_le_bytes().into()),
                vec![z.to_le_bytes()[0]],
                order(intensity.to_le_bytes().into()),
                vec![ring],
                vec![0xee; 5],
            ];
            parts.concat()
        };
        let data = [point(-300, 40_000, -7, 0.25, 9), point(2, 3, 4, 200.0, 127)].concat();
        let mut message = cloud(fields, 20, 2, data);
        message.is_bigendian = big_endian.into();
        let scan = read(message).unwrap();
        assert_eq!(scan.points[0].position_m(), [-300.0, 40_000.0, -7.0]);
        assert_eq!((scan.points[0].intensity, scan.points[0].ring), (0.25, 9));
        assert_eq!((scan.points[1].intensity, scan.points[1].ring), (200.0, 127));
        assert_eq!((scan.stamp_ns, scan.frame_id.as_str()), (at_ms(0), "lidar"));
        assert!(scan.columns.ring && !scan.columns.column && !scan.columns.time && !scan.columns.return_type);
    }
    let scan = with_field("channel", 5, &7_i32.to_le_bytes());
    assert_eq!(scan.points[0].ring, 7);
    let scan = with_field("label", 6, &4_000_000_000_u32.to_le_bytes());
    assert_eq!((scan.points[0].label, scan.points[0].ring), (4_000_000_000, Point::UNKNOWN));
}

#[test]
fn times_of_all_common_units_are_seconds_after_the_stamp() {
    let stamp_s = STAMP_NS as f64 * 1e-9;
    let at = |name, datatype, value: &[u8]| with_field(name, datatype, value).points[0].time_s;
    let cases = [
        at("t", 6, &50_000_000_u32.to_le_bytes()),
        at("time_stamp", 6, &50_000_u32.to_le_bytes()),
        at("time", 7, &0.05_f32.to_le_bytes()),
        at("time", 7, &5e4_f32.to_le_bytes()),
        at("time", 7, &5e7_f32.to_le_bytes()),
        at("timestamp", 8, &(stamp_s + 0.05).to_le_bytes()),
        at("timestamp", 8, &((stamp_s + 0.05) * 1e6).to_le_bytes()),
        at("timestamp", 8, &((stamp_s + 0.05) * 1e9).to_le_bytes()),
    ];
    for (case, time_s) in cases.into_iter().enumerate() {
        assert!((time_s - 0.05).abs() < 2e-6, "case {case}: {time_s}");
    }
    assert_eq!(at("time", 7, &(-0.05_f32).to_le_bytes()), -0.05, "where the stamp is that of the end");
}

#[test]
fn returns_are_numbered_as_stated() {
    let code = |codes: ReturnCodes, code: u8| codes.decode(code.into());
    use ReturnCodes::{Autoware, FirstLast, StrongestLast};
    use ReturnType::{Both, First, Last, StrongestOrSecond};
    assert_eq!(code(FirstLast, 1), Some((First, Strength::Unknown)));
    assert_eq!(code(StrongestLast, 1), Some((StrongestOrSecond, Strength::Unknown)));
    assert_eq!(code(StrongestLast, 3), Some((Both, Strength::Unknown)));
    assert_eq!(code(Autoware, 8), Some((Last, Strength::Stronger)));
    assert_eq!([code(FirstLast, 9), code(StrongestLast, 0), code(Autoware, 0)], [None; 3]);
    let scan = with_field("return_type", 2, &[2]);
    assert!(scan.points[0].return_type == Last && scan.columns.return_type);
    assert_eq!(with_field("return", 7, &1.0_f32.to_le_bytes()).points[0].return_type, First);
    let scan = with_field("return_type", 2, &[9]);
    assert_eq!((scan.points.len(), scan.dropped.count(DropReason::ReturnCode)), (0, 1));
}

#[test]
fn organized_clouds_have_rings_and_columns() {
    let points: Vec<[f32; 4]> = (0..12).map(|at| [at as f32 + 1.0, 0.0, 0.0, 1.0]).collect();
    let shaped = |height: u32, width: u32| {
        let mut message = xyzi(&points);
        (message.height, message.width, message.row_step) = (height, width, 16 * width);
        let scan = read(message).unwrap();
        assert!(scan.columns.ring && scan.columns.column);
        scan.points.iter().map(|point| [point.ring, point.column]).collect::<Vec<_>>()
    };
    assert_eq!(shaped(3, 4)[5], [1, 1]);
    assert_eq!(shaped(3, 4)[11], [2, 3]);
    assert_eq!(shaped(6, 2)[5], [1, 2], "rings are the shorter side");
    // Rows with padding at their ends.
    let mut message = xyzi(&points);
    (message.height, message.width, message.row_step) = (2, 5, 96);
    let xs: Vec<f32> = read(message).unwrap().points.iter().map(|point| point.x_m).collect();
    assert_eq!(xs, [1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 8.0, 9.0, 10.0, 11.0]);
}

fn foxglove_cloud(pose: Option<foxglove::Pose>) -> foxglove::PointCloud {
    let message = xyzi(&[[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0]]);
    let field = |name: &str, offset: u32| PackedElementField {
        name: name.into(),
        offset,
        r#type: NumericType::Float32.into(),
    };
    foxglove::PointCloud {
        timestamp: Some(foxglove::Timestamp { seconds: 1000, nanos: 0 }),
        frame_id: "lidar".into(),
        pose,
        point_stride: 16,
        fields: vec![field("x", 0), field("y", 4), field("z", 8), field("intensity", 12)],
        data: message.data,
    }
}

#[test]
fn foxglove_clouds_are_placed_by_their_pose() {
    let options = Options::default();
    let plain = from_foxglove(&foxglove_cloud(None), &options).unwrap();
    assert_eq!(plain.points[1].position_m(), [5.0, 6.0, 7.0]);
    assert_eq!((plain.stamp_ns, plain.frame_id.as_str()), (at_ms(0), "lidar"));
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let pose = foxglove::Pose {
        position: Some(foxglove::Vector3 { x: 10.0, y: 0.0, z: 0.0 }),
        orientation: Some(foxglove::Quaternion { x: 0.0, y: 0.0, z: half, w: half }),
    };
    let turned = from_foxglove(&foxglove_cloud(Some(pose)), &options).unwrap();
    let [x, y, z] = turned.points[0].position_m();
    assert!((x - 8.0).abs() < 1e-6 && (y - 1.0).abs() < 1e-6 && z == 3.0, "{turned:?}");
    let nowhere = foxglove::Pose { position: None, orientation: Some(foxglove::Quaternion::default()) };
    refused(from_foxglove(&foxglove_cloud(Some(nowhere)), &options), &["foxglove.PointCloud", "pose"]);
    let empty = foxglove::Pose::default();
    assert_eq!(from_foxglove(&foxglove_cloud(Some(empty)), &options).unwrap(), plain);
}

#[test]
fn foxglove_clouds_of_wrong_sizes_are_refused() {
    let wrong = |change: fn(&mut foxglove::PointCloud)| {
        let mut message = foxglove_cloud(None);
        change(&mut message);
        from_foxglove(&message, &Options::default())
    };
    refused(wrong(|message| message.point_stride = 0), &["point_stride is 0"]);
    let short = |message: &mut foxglove::PointCloud| {
        message.point_stride = 14;
        message.data.truncate(28);
    };
    refused(wrong(short), &["field `intensity`", "past the point's 14 bytes"]);
    refused(wrong(|message| message.data.truncate(31)), &["31 bytes", "points of 16"]);
    refused(wrong(|message| message.fields[1].r#type = 77), &["field `y`", "unknown type"]);
    refused(wrong(|message| message.timestamp = None), &["stamp"]);
    refused(wrong(|message| message.fields.truncate(2)), &["foxglove.PointCloud", "no field `z`"]);
}

/// As ROS 1 has it.
fn ros1(message: &PointCloud2) -> Vec<u8> {
    let number = |value: u32| u32s(&[value as usize]);
    let mut bytes = [header(at_ms(0), "/lidar"), number(message.height), number(message.width)].concat();
    bytes.extend(u32s(&[message.fields.len()]));
    for field in &message.fields {
        bytes.extend(
            [sized(field.name.as_bytes()), number(field.offset), vec![field.datatype], number(1)].concat(),
        );
    }
    bytes.push(message.is_bigendian);
    bytes.extend(
        [number(message.point_step), number(message.row_step), sized(&message.data), vec![1]].concat(),
    );
    bytes
}

/// As the message that came before it.
fn old(points: &[[f32; 4]]) -> PointCloud {
    let channel = |name: &str, number: fn(&[f32; 4]) -> f32| ChannelFloat32 {
        name: name.into(),
        values: points.iter().map(number).collect(),
    };
    PointCloud {
        header: Header::new(at_ms(0), "/lidar"),
        points: points.iter().map(|&[x, y, z, _]| Point32 { x, y, z }).collect(),
        channels: vec![channel("intensity", |point| point[3]), channel("index", |_| f32::NAN)],
    }
}

#[test]
fn clouds_of_old_have_fields_by_their_channels() {
    let options = Options::default();
    let points = [[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0]];
    let expected = read(xyzi(&points)).unwrap();
    assert_eq!(from_old(old(&points), &options).unwrap(), expected);
    let mut recorder = Recorder::new();
    recorder.ros("/points", "sensor_msgs/msg/PointCloud", at_ms(0), &old(&points));
    let (scans, report) = read_bytes("old.mcap", &recorder.finish()).unwrap();
    assert_eq!(scans, [expected], "{report:?}");
    let mut short = old(&points);
    short.channels[1].values.pop();
    refused(
        from_old(short, &options),
        &["sensor_msgs/PointCloud", "channel `index`", "1 values for 2 points"],
    );
    let mut twice = old(&points);
    twice.channels[1].name = "x".into();
    refused(from_old(twice, &options), &["field `x` twice"]);
    let places = PointCloud { points: vec![Point32::default(); (1 << 22) + 1], ..old(&[]) };
    refused(
        from_old(PointCloud { channels: vec![], ..places }, &options),
        &["4194305 points", "at most 4194304"],
    );
    assert!(from_old(old(&[]), &options).unwrap().points.is_empty());
}

#[test]
fn foxglove_clouds_of_too_many_points_are_refused() {
    let message = foxglove::PointCloud { data: vec![0; 16 * ((1 << 22) + 1)], ..foxglove_cloud(None) };
    refused(from_foxglove(&message, &Options::default()), &["4194305 points", "at most 4194304"]);
}

#[test]
fn all_containers_give_the_same_scans() {
    let message = xyzi(&[[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0]]);
    let expected = read(message.clone()).unwrap();
    let [mut cdr, mut ros1_mcap, mut protobuf] = [(); 3].map(|()| Recorder::new());
    let mut bag = Bag::new(Compression::Bz2);
    cdr.ros("/points", CLOUD, at_ms(0), &message);
    ros1_mcap.bytes("/points", "sensor_msgs/PointCloud2", "ros1", at_ms(0), &ros1(&message));
    protobuf.foxglove("/points", "foxglove.PointCloud", at_ms(0), &foxglove_cloud(None));
    bag.message("/points", "sensor_msgs/PointCloud2", at_ms(0), &ros1(&message));
    for bytes in [cdr.finish(), ros1_mcap.finish(), protobuf.finish(), bag.finish()] {
        let (scans, report) = read_bytes("recording", &bytes).unwrap();
        assert_eq!(scans, std::slice::from_ref(&expected));
        assert!(report.read.skipped.is_empty(), "{report:?}");
        assert_eq!(report.read.notes, ["topic: /points"]);
    }
}

#[test]
fn topics_are_found_by_type_or_stated() {
    let mut recorder = Recorder::new();
    recorder.depth(at_ms(0), 7);
    recorder.ros("/b/points", CLOUD, at_ms(0), &xyzi(&[[1.0; 4]]));
    recorder.ros("/a/points", CLOUD, at_ms(0), &xyzi(&[[2.0; 4]; 2]));
    let bytes = recorder.finish();
    let (scans, report) = read_bytes("two.mcap", &bytes).unwrap();
    assert_eq!((scans.len(), scans[0].points.len()), (1, 2));
    assert!(report.read.notes[0].contains("/a/points (others with scans: /b/points)"), "{report:?}");
    let stated = |topic: &str| {
        let options = Options { topic: Some(topic.into()), ..Options::default() };
        read_with("two.mcap", &bytes, &options)
    };
    assert_eq!(stated("/b/points").unwrap().0[0].points.len(), 1);
    refused(stated("/c/points"), &["topic", "`/c/points`", "/a/points"]);
    refused(stated("/cam/depth/image_raw"), &["/cam/depth/image_raw", "sensor_msgs/msg/Image"]);
    let mut without = Recorder::new();
    without.depth(at_ms(0), 7);
    refused(
        read_bytes("depth.mcap", &without.finish()),
        &["depth.mcap", "no point cloud, laser scan", "/cam/depth/image_raw"],
    );
}

#[test]
fn intensities_go_by_many_names_or_none() {
    let named = |name: &str, options: &Options| {
        let mut message = xyzi(&[[1.0, 2.0, 3.0, 44.0]]);
        message.fields[3].name = name.into();
        from_ros(message, options).unwrap()
    };
    let usual = Options::default();
    let names =
        ["intensity", "Intensity", "scalar_Intensity", "intensities", "reflectivity", "i", "I", "signal"];
    for name in names.into_iter().chain(["reflectance", "remission"]) {
        let scan = named(name, &usual);
        assert!(scan.points[0].intensity == 44.0 && scan.columns.intensity, "{name}");
    }
    let scan = named("my_echo", &usual);
    assert!(scan.points[0].intensity == 0.0 && !scan.columns.intensity);
    let stated = Options { intensity_field: Some("my_echo".into()), ..Options::default() };
    assert_eq!(named("my_echo", &stated).points[0].intensity, 44.0);
    refused(from_ros(xyzi(&[[1.0; 4]]), &stated), &["no field `my_echo`", "its fields: x, y, z, intensity"]);
    // Where all of them are NaN nothing was measured; one NaN among others is a bad point.
    let nans = read(xyzi(&[[1.0, 2.0, 3.0, f32::NAN], [4.0, 5.0, 6.0, f32::NAN]])).unwrap();
    assert!(nans.points.len() == 2 && !nans.columns.intensity);
    let one = read(xyzi(&[[1.0, 2.0, 3.0, f32::NAN], [4.0, 5.0, 6.0, 7.0]])).unwrap();
    assert!(one.points.len() == 1 && one.columns.intensity);
}

#[test]
fn a_line_or_a_laser_is_no_ring() {
    for name in ["line", "laser"] {
        assert!(!with_field(name, 2, &[3]).columns.ring, "{name}");
    }
    assert!(with_field("ring", 2, &[3]).columns.ring && with_field("channel", 2, &[3]).columns.ring);
}

#[test]
fn a_cloud_of_many_points_is_refused_before_it_is_unpacked() {
    let mut message = xyzi(&[[1.0; 4]]);
    (message.width, message.height) = (30_000_000, 1);
    let head = limpid::message::ros2::encode_cdr(CLOUD, &message).unwrap();
    let mut recorder = Recorder::new();
    recorder.bytes("/points", CLOUD, "cdr", at_ms(0), &head);
    let (scans, report) = read_bytes("large.mcap", &recorder.finish()).unwrap();
    assert!(scans.is_empty() && report.read.skipped[0].reason.contains("30000000 points"), "{report:?}");
}
