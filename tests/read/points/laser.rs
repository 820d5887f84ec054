//! Flat scans and Livox clouds: truth by hand, limits as the messages define them.

use std::f32::consts::{FRAC_PI_2, PI};

use limpid::input::points::laser::{from_foxglove, from_laser_scan, from_multi_echo};
use limpid::input::points::livox::from_custom_msg;
use limpid::message::foxglove;
use limpid::message::lidar::{CustomMsg, CustomPoint, LaserEcho, LaserScan, MultiEchoLaserScan};
use limpid::message::ros2::Header;
use limpid::sensor::{DropReason, Point, PointClock, ReturnType};

use super::{read_bytes, refused};
use crate::read::ros1::{Bag, Compression, header, u32s};
use crate::read::synthetic::{Recorder, at_ms};

/// A quarter turn a ray from ahead, 10 ms from one to the next.
fn flat(ranges: &[f32]) -> LaserScan {
    LaserScan {
        header: Header::new(at_ms(0), "/laser"),
        angle_min: 0.0,
        angle_max: PI,
        angle_increment: FRAC_PI_2,
        time_increment: 0.01,
        scan_time: 0.1,
        range_min: 0.1,
        range_max: 10.0,
        ranges: ranges.into(),
        intensities: Vec::new(),
    }
}

fn near(point: &Point, [x, y]: [f32; 2]) -> bool {
    (point.x_m - x).abs() < 1e-5 && (point.y_m - y).abs() < 1e-5 && point.z_m == 0.0
}

#[test]
fn rays_are_points_of_one_ring_at_their_times() {
    let scan =
        from_laser_scan(LaserScan { intensities: vec![7.0, 8.0, 9.0], ..flat(&[1.0, 2.0, 3.0]) }).unwrap();
    let expected = [[1.0, 0.0], [0.0, 2.0], [-3.0, 0.0]];
    assert!(scan.points.iter().zip(expected).all(|(point, at)| near(point, at)), "{scan:?}");
    let values: Vec<_> = scan.points.iter().map(|p| (p.intensity, p.ring, p.column)).collect();
    assert_eq!(values, [(7.0, 0, 0), (8.0, 0, 1), (9.0, 0, 2)]);
    assert!((scan.points[2].time_s - 0.02).abs() < 1e-6);
    assert_eq!((scan.stamp_ns, scan.frame_id.as_str()), (at_ms(0), "laser"));
    assert!(scan.columns.intensity && scan.columns.time);
    let without = from_laser_scan(LaserScan { time_increment: 0.0, ..flat(&[1.0]) }).unwrap();
    assert!(!without.columns.intensity && !without.columns.time);
    let short = LaserScan { intensities: vec![1.0], ..flat(&[1.0, 2.0]) };
    assert!(!from_laser_scan(short).unwrap().columns.intensity, "not one for each range");
}

#[test]
fn ranges_outside_of_the_limits_are_left_out_by_reason() {
    let (inf, nan) = (f32::INFINITY, f32::NAN);
    let scan = from_laser_scan(flat(&[0.09, 0.1, 9.99, 10.0, 10.1, inf, -inf, nan, -1.0, 0.0])).unwrap();
    assert_eq!(scan.points.iter().map(|p| p.column).collect::<Vec<_>>(), [1, 2]);
    assert_eq!(scan.dropped.count(DropReason::NoReturn), 7);
    assert_eq!(scan.dropped.count(DropReason::NotFinite), 1);
    let open = from_laser_scan(LaserScan { range_max: inf, ..flat(&[50.0, inf]) }).unwrap();
    assert_eq!(open.points.len(), 1);
    refused(
        from_laser_scan(LaserScan { angle_increment: 0.0, ..flat(&[1.0; 2]) }),
        &["LaserScan", "angle_increment"],
    );
    refused(from_laser_scan(LaserScan { angle_min: nan, ..flat(&[1.0]) }), &["LaserScan", "not finite"]);
    refused(from_laser_scan(LaserScan { range_max: nan, ..flat(&[1.0]) }), &["LaserScan", "not finite"]);
    // Finite for a ray, and not for the last.
    let late = LaserScan { time_increment: f32::MAX, ..flat(&[1.0; 3]) };
    refused(from_laser_scan(late), &["LaserScan", "not finite"]);
    assert!(from_laser_scan(LaserScan { time_increment: f32::MAX, ..flat(&[1.0]) }).is_ok());
    let echoes = vec![LaserEcho { echoes: vec![1.0] }; 3];
    let late = LaserScan { time_increment: f32::MAX, ..flat(&[]) };
    let late = MultiEchoLaserScan { ranges: echoes, ..multi_of(late) };
    refused(from_multi_echo(late), &["MultiEchoLaserScan", "not finite"]);
    let wide = foxglove::LaserScan { start_angle: -1e308, end_angle: 1e308, ..foxglove_flat(&[1.0; 3]) };
    refused(from_foxglove(wide), &["foxglove.LaserScan", "not finite"]);
    let mut far = foxglove_flat(&[1.0]);
    let position = Some(foxglove::Vector3 { x: 1e300, y: 0.0, z: 0.0 });
    far.pose = far.pose.map(|pose| foxglove::Pose { position, ..pose });
    refused(from_foxglove(far), &["foxglove.LaserScan", "pose", "farther"]);
}

/// A scan of the same rays without any echo.
fn multi_of(flat: LaserScan) -> MultiEchoLaserScan {
    MultiEchoLaserScan {
        header: flat.header,
        angle_min: flat.angle_min,
        angle_max: flat.angle_max,
        angle_increment: flat.angle_increment,
        time_increment: flat.time_increment,
        scan_time: flat.scan_time,
        range_min: flat.range_min,
        range_max: flat.range_max,
        ..MultiEchoLaserScan::default()
    }
}

#[test]
fn echoes_are_returns_of_one_beam() {
    let echoes = |values: &[f32]| LaserEcho { echoes: values.into() };
    let message = MultiEchoLaserScan {
        ranges: vec![echoes(&[1.0, 2.0, 11.0]), echoes(&[]), echoes(&[3.0])],
        intensities: vec![echoes(&[5.0, 6.0, 7.0]), echoes(&[]), echoes(&[8.0])],
        ..multi_of(flat(&[]))
    };
    let scan = from_multi_echo(message).unwrap();
    let found: Vec<_> = scan.points.iter().map(|p| (p.column, p.return_type, p.intensity)).collect();
    let expected = [(0, ReturnType::First, 5.0), (0, ReturnType::Last, 6.0), (2, ReturnType::Both, 8.0)];
    assert_eq!(found, expected);
    assert!(near(&scan.points[1], [2.0, 0.0]) && near(&scan.points[2], [-3.0, 0.0]));
    assert_eq!((scan.dropped.total(), scan.columns.intensity, scan.columns.return_type), (1, true, true));
}

/// As [`flat`], from a sensor that is turned by a quarter and stands a metre up.
fn foxglove_flat(ranges: &[f64]) -> foxglove::LaserScan {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let position = foxglove::Vector3 { x: 0.0, y: 0.0, z: 1.0 };
    let orientation = foxglove::Quaternion { x: 0.0, y: 0.0, z: half, w: half };
    foxglove::LaserScan {
        timestamp: Some(foxglove::Timestamp { seconds: 1000, nanos: 0 }),
        frame_id: "/laser".into(),
        pose: Some(foxglove::Pose { position: Some(position), orientation: Some(orientation) }),
        start_angle: 0.0,
        end_angle: std::f64::consts::PI,
        ranges: ranges.into(),
        intensities: vec![7.0, 8.0, 9.0],
    }
}

#[test]
fn a_scan_of_foxglove_lies_where_its_pose_says() {
    let scan = from_foxglove(foxglove_flat(&[1.0, 2.0, f64::INFINITY])).unwrap();
    let expected = [[0.0, 1.0, 1.0], [-2.0, 0.0, 1.0]];
    let near =
        |found: [f32; 3], expected: [f32; 3]| found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5);
    assert!(scan.points.iter().zip(expected).all(|(point, at)| near(point.position_m(), at)), "{scan:?}");
    assert_eq!((scan.points.len(), scan.points[1].intensity, scan.points[1].ring), (2, 8.0, 0));
    assert_eq!((scan.frame_id.as_str(), scan.stamp_ns), ("laser", at_ms(0)));
    let mut recorder = Recorder::new();
    recorder.foxglove("/scan", "foxglove.LaserScan", at_ms(0), &foxglove_flat(&[1.0, 2.0, f64::INFINITY]));
    assert_eq!(read_bytes("flat.mcap", &recorder.finish()).unwrap().0, [scan]);
    refused(from_foxglove(foxglove::LaserScan { end_angle: 0.0, ..foxglove_flat(&[1.0; 3]) }), &["angle"]);
    assert_eq!(from_foxglove(foxglove_flat(&[1.0])).unwrap().points.len(), 1);
}

/// More than are read.
const TOO_MANY: usize = (1 << 22) + 1;

#[test]
fn scans_of_too_many_points_are_refused() {
    let parts = &["4194305 points", "at most 4194304"];
    refused(from_laser_scan(flat(&vec![1.0; TOO_MANY])), parts);
    refused(from_foxglove(foxglove_flat(&vec![1.0; TOO_MANY])), parts);
    let ray = LaserEcho { echoes: vec![1.0; TOO_MANY] };
    refused(from_multi_echo(MultiEchoLaserScan { ranges: vec![ray], ..multi_of(flat(&[])) }), parts);
    refused(from_custom_msg(livox(0, vec![POINT; TOO_MANY])), parts);
}

#[test]
fn a_livox_claim_is_refused_before_its_points_are_unpacked() {
    let message = CustomMsg { point_num: 30_000_000, ..livox(at_ms(0), vec![POINT]) };
    let mut recorder = Recorder::new();
    recorder.ros("/livox/lidar", "livox_ros_driver2/msg/CustomMsg", at_ms(0), &message);
    let (scans, report) = read_bytes("livox.mcap", &recorder.finish()).unwrap();
    assert!(
        scans.is_empty() && report.read.skipped[0].reason.contains("30000000 points; at most"),
        "{report:?}"
    );
}

fn livox(timebase: u64, points: Vec<CustomPoint>) -> CustomMsg {
    let header = Header::new(1_700_000_000_000_000_000, "livox_frame");
    CustomMsg { header, timebase, point_num: points.len() as u32, lidar_id: 1, rsvd: [0; 3], points }
}

const POINT: CustomPoint =
    CustomPoint { offset_time: 30_000_000, x: 1.0, y: 2.0, z: 3.0, reflectivity: 44, tag: 16, line: 3 };

#[test]
fn a_custom_message_has_times_and_no_rings() {
    let scan = from_custom_msg(livox(1_700_000_000_010_000_000, vec![POINT])).unwrap();
    let point = scan.points[0];
    assert_eq!((point.position_m(), point.intensity, point.ring), ([1.0, 2.0, 3.0], 44.0, Point::UNKNOWN));
    assert!((point.time_s - 0.04).abs() < 1e-6, "{}", point.time_s);
    assert!(scan.columns.time && !scan.columns.ring && scan.columns.clock == PointClock::Stamp);
    // Since the sensor's boot.
    let scan = from_custom_msg(livox(12_345_000_000, vec![POINT])).unwrap();
    assert!((scan.points[0].time_s - 0.03).abs() < 1e-6 && scan.columns.clock == PointClock::Own);
    let nothing = CustomPoint { x: 0.0, y: 0.0, z: 0.0, ..POINT };
    let bad = CustomPoint { x: f32::NAN, ..POINT };
    let scan = from_custom_msg(livox(0, vec![nothing, bad])).unwrap();
    assert_eq!((scan.points.len(), scan.dropped.total()), (0, 2));
    refused(
        from_custom_msg(CustomMsg { point_num: 30_000_000, ..livox(0, vec![POINT]) }),
        &["point_num is 30000000 for 1"],
    );
}

fn livox_ros1(timebase: u64, points: &[CustomPoint]) -> Vec<u8> {
    let mut bytes = [header(at_ms(0), "livox_frame"), timebase.to_le_bytes().into()].concat();
    bytes.extend(u32s(&[points.len()]));
    bytes.extend([1, 0, 0, 0]);
    bytes.extend(u32s(&[points.len()]));
    for point in points {
        bytes.extend(point.offset_time.to_le_bytes());
        bytes.extend([point.x, point.y, point.z].iter().flat_map(|value| value.to_le_bytes()));
        bytes.extend([point.reflectivity, point.tag, point.line]);
    }
    bytes
}

#[test]
fn messages_of_both_ros_give_the_same_scans() {
    let points = vec![POINT, CustomPoint { x: 4.0, ..POINT }];
    let message =
        CustomMsg { header: Header::new(at_ms(0), "livox_frame"), ..livox(at_ms(0), points.clone()) };
    let expected = from_custom_msg(message.clone()).unwrap();
    let mut mcap = Recorder::new();
    mcap.ros("/livox/lidar", "livox_ros_driver2/msg/CustomMsg", at_ms(0), &message);
    let mut bag = Bag::new(Compression::Lz4);
    bag.message("/livox/lidar", "livox_ros_driver/CustomMsg", at_ms(0), &livox_ros1(at_ms(0), &points));
    for bytes in [mcap.finish(), bag.finish()] {
        let (scans, report) = read_bytes("recording", &bytes).unwrap();
        assert_eq!(scans, std::slice::from_ref(&expected), "{report:?}");
    }
    let mut recorder = Recorder::new();
    recorder.ros("/scan", "sensor_msgs/msg/LaserScan", at_ms(0), &flat(&[1.0, 2.0, 3.0]));
    let (scans, _) = read_bytes("flat.mcap", &recorder.finish()).unwrap();
    assert_eq!(scans, [from_laser_scan(flat(&[1.0, 2.0, 3.0])).unwrap()]);
}
