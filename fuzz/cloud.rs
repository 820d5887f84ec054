//! Any bytes as clouds, flat scans and Livox clouds: errors or finite points, at most one for each byte.
#![no_main]

use libfuzzer_sys::fuzz_target;
use limpid::message::{foxglove, ros1, ros2};
use limpid::input::points::{Options, cloud, laser, livox, pcd, ply};
use limpid::sensor::Scan;

fn check(scan: limpid::Result<Scan>, bytes: usize) {
    let Ok(scan) = scan else { return };
    assert!(scan.points.len() <= bytes);
    for point in &scan.points {
        let [x, y, z] = point.position_m();
        assert!([x, y, z, point.intensity, point.time_s].iter().all(|value| value.is_finite()));
    }
}

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, bytes)) = bytes.split_first() else { return };
    let options = Options::default();
    let scan = match kind % 11 {
        0 => ros2::decode_cdr("", bytes).and_then(|message| cloud::from_ros(message, &options)),
        1 => ros1::decode("", bytes).and_then(|message| cloud::from_ros(message, &options)),
        2 => foxglove::decode_protobuf("", bytes).and_then(|message| cloud::from_foxglove(&message, &options)),
        3 => ply::read(bytes, 0, &options),
        4 => ros2::decode_cdr("", bytes).and_then(laser::from_laser_scan),
        5 => ros1::decode("", bytes).and_then(laser::from_laser_scan),
        6 => ros2::decode_cdr("", bytes).and_then(laser::from_multi_echo),
        7 => ros1::decode("", bytes).and_then(laser::from_multi_echo),
        8 => ros2::decode_cdr("", bytes).and_then(livox::from_custom_msg),
        9 => ros1::decode("", bytes).and_then(livox::from_custom_msg),
        _ => pcd::read(bytes, 0, &options),
    };
    check(scan, bytes.len());
});
