//! Raw packets of simulated Velodynes: limpid's own decoder makes the simulated scans of them.

use std::path::Path;

use glam::DVec3;
use limpid::input::points::{Options, open};
use limpid::message::ros2::{PointCloud2, decode_cdr};
use limpid::sensor::{Scan, VelodyneModel};
use limpid::sim::Scene;
use limpid::sim::lidar::{Lidar, LidarModel, LidarSimulator, Returns, SimScan};
use limpid::sim::write::recorder;

use super::{in_map, robot, room_with_lidar};
use crate::support::gpu::{context, skipped};

/// A distance is off by half a count of 4 mm, an azimuth by two roundings of a hundredth of a degree in some 4 m.
const OFF_M: f32 = 0.004;

fn with_packets(model: LidarModel, returns: Returns) -> Scene {
    let mut scene = room_with_lidar();
    scene.lidar = Some(Lidar { model, returns, rate_hz: 20.0, packets: true, ..Lidar::default() });
    scene
}

/// Two revolutions of a robot that stands, as they were simulated and as they are read; the truth of the points as written.
fn recorded(scene: &Scene, path: &Path) -> (Vec<SimScan>, Vec<Scan>, Vec<PointCloud2>) {
    let mut lidar = LidarSimulator::with_context(scene, &context()).unwrap();
    let mut file = recorder(path, scene, false).unwrap();
    let mut simulated = Vec::new();
    for index in 0..2 {
        let start_ns = 5_000_000_000 + index * lidar.period_ns();
        let scan = lidar.scan(index, start_ns, |_| robot(0.0, 0.0, 0.3)).unwrap();
        file.write_pose(start_ns, robot(0.0, 0.0, 0.3)).unwrap();
        file.write_scan(&scan, start_ns + lidar.period_ns()).unwrap();
        simulated.push(scan);
    }
    file.finish().unwrap();
    let mut reader = open(path, &Options::default()).unwrap();
    let read = std::iter::from_fn(|| reader.next_scan().unwrap()).collect();
    let bytes = std::fs::read(path).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
    let truth = messages.filter(|message| message.channel.topic == "/truth/points");
    (simulated, read, truth.map(|message| decode_cdr("PointCloud2", &message.data).unwrap()).collect())
}

fn same_points(simulated: &SimScan, read: &Scan) {
    assert_eq!(read.points.len(), simulated.scan.points.len());
    let key = |point: &limpid::sensor::Point| (point.column, point.ring, point.return_type as u8);
    let mut wanted = simulated.scan.points.clone();
    let mut got = read.points.clone();
    wanted.sort_by_key(key);
    got.sort_by_key(key);
    for (got, want) in got.iter().zip(&wanted) {
        assert_eq!((got.column, got.ring), (want.column, want.ring));
        assert!(
            (got.return_type, got.strength) == (want.return_type, want.strength) || want.intensity >= 254.5,
            "{got:?} {want:?}"
        );
        for (got_m, want_m) in got.position_m().iter().zip(want.position_m()) {
            assert!((got_m - want_m).abs() < OFF_M, "{got:?} {want:?}");
        }
        assert!((got.intensity - want.intensity.min(255.0)).abs() <= 0.5);
        assert!((got.time_s - want.time_s).abs() < 3e-6, "{} {}", got.time_s, want.time_s);
    }
}

#[test]
fn truth_the_decoder_makes_the_simulated_scan_of_them() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for (model, returns, sent) in [
        (LidarModel::Vlp16, Returns::StrongestLast, VelodyneModel::Vlp16),
        (LidarModel::Vlp16, Returns::Strongest, VelodyneModel::Vlp16),
        (LidarModel::Hdl32e, Returns::StrongestLast, VelodyneModel::Hdl32e),
        (LidarModel::Vlp32c, Returns::StrongestLast, VelodyneModel::Vlp32c),
    ] {
        let scene = with_packets(model, returns);
        let path = folder.path().join(format!("{}-{returns:?}.mcap", sent.name()));
        let (simulated, read, truth) = recorded(&scene, &path);
        assert_eq!((read.len(), truth.len()), (2, 2), "{model:?}");
        for ((simulated, read), truth) in simulated.iter().zip(&read).zip(&truth) {
            assert!(simulated.scan.points.len() > 5_000);
            assert!(read.stamp_ns.abs_diff(simulated.scan.stamp_ns) < 1_000);
            same_points(simulated, read);
            // The truth is in the order in which the packets are decoded: all that the room sent back lies where it was met.
            assert_eq!(truth.width as usize, read.points.len());
            for (point, words) in read.points.iter().zip(truth.data.chunks_exact(truth.point_step as usize)) {
                let metres = |at: usize| f64::from(f32::from_le_bytes(words[at..at + 4].try_into().unwrap()));
                let met = DVec3::new(metres(0), metres(4), metres(8));
                let measured = in_map(&scene, robot(0.0, 0.0, 0.3), point);
                assert!(measured.distance(met) < 0.12, "{model:?}: {measured} {met}");
            }
        }
    }
}

#[test]
fn sensors_that_send_no_such_packets_are_named() {
    for (model, returns, part) in [
        (LidarModel::Os1x64, Returns::StrongestLast, "OS1-64"),
        (LidarModel::Qt64, Returns::StrongestLast, "PandarQT64"),
        (LidarModel::Vlp16, Returns::FirstLast, "strongest and the last"),
    ] {
        let reason = with_packets(model, returns).validate().unwrap_err().to_string();
        assert!(reason.contains("lidar.packets") && reason.contains(part), "{reason}");
    }
}
