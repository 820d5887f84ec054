//! Matt walls: places, intensities, rings, edges, motion.

use std::collections::HashSet;

use limpid::sensor::ReturnType;
use limpid::sim::lidar::{Lidar, LidarModel, LidarSimulator, Returns};

use super::{in_map, pairs, robot, room_with_lidar, scan_from, scan_of};
use crate::sim::a_box;
use crate::support::gpu::{context, skipped};

/// Six deviations of the range.
const NOISE_M: f64 = 6.0 * 0.015;

/// How far a point of the map is from the nearest surface of the empty small room.
fn off_the_room(at: glam::DVec3) -> f64 {
    let planes = [at.x - 3.0, at.x + 3.0, at.y - 2.0, at.y + 2.0, at.z, at.z - 2.5];
    planes.into_iter().map(f64::abs).fold(f64::INFINITY, f64::min)
}

#[test]
fn truth_every_beam_of_a_room_returns_from_a_wall() {
    if skipped() {
        return;
    }
    let (scene, pose) = (room_with_lidar(), robot(0.5, -0.3, 0.4));
    let scan = scan_from(&scene, pose);
    assert_eq!(scan.beams, 452 * 16);
    assert_eq!(scan.truth.len(), scan.beams as usize, "one return a beam");
    for (point, truth) in pairs(&scan) {
        let at = in_map(&scene, pose, point);
        assert!(off_the_room(at) < NOISE_M, "{at}");
        // Sub-rays spread by 1.5 mrad, and rays along the floor by more.
        assert!(at.distance(truth.place_m) < NOISE_M + 0.15, "{at} {truth:?}");
        assert!(off_the_room(truth.place_m) < 0.006, "{truth:?}");
        assert_eq!((truth.flags, point.return_type), (0, ReturnType::Both));
    }
    let rings: HashSet<u16> = scan.scan.points.iter().map(|point| point.ring).collect();
    assert_eq!(rings.len(), 16);
    // The lowest ring first, the columns clockwise from ahead with their times. Its beam crosses the axis above the centre.
    let first = &scan.scan.points[0];
    let lowest = LidarModel::Vlp16.optics().rings[0];
    let up_m = f64::from(first.z_m) - lowest.offset_m;
    assert!((lowest.offset_m - 0.0112).abs() < 1e-4, "{lowest:?}");
    let elevation_deg = up_m.atan2(f64::from(first.x_m).hypot(f64::from(first.y_m))).to_degrees();
    assert!((elevation_deg + 15.0).abs() < 1e-3, "{elevation_deg}");
    let quarter = scan.scan.points.iter().find(|point| point.column == 113).unwrap();
    assert!(quarter.y_m < -1.0 && quarter.x_m.abs() < 0.05, "{quarter:?}");
    assert!((f64::from(quarter.time_s) - 0.025 / 4.0).abs() < 1e-6);
}

#[test]
fn truth_calibrated_intensity_is_reflectivity_times_the_cosine() {
    if skipped() {
        return;
    }
    let scan = scan_of(&room_with_lidar());
    // Ring 7 looks down by a degree; ahead the wall is met head on, to the right of it at an angle.
    for (column, cosine) in [(0, 1.0), (30, f64::to_radians(30.0 * 360.0 / 452.0).cos())] {
        let near = scan.scan.points.iter().filter(|p| p.ring == 7 && p.column.abs_diff(column) < 3);
        let values: Vec<f64> = near.map(|p| f64::from(p.intensity)).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        assert!((mean / (50.0 * cosine) - 1.0).abs() < 0.15, "{column}: {mean}");
    }
}

#[test]
fn truth_uncalibrated_intensity_falls_with_the_range() {
    if skipped() {
        return;
    }
    let mut scene = room_with_lidar();
    scene.lidar = Some(Lidar { model: LidarModel::Os1x64, rate_hz: 40.0, ..Lidar::default() });
    let scan = scan_of(&scene);
    let at = |column: u16| {
        let near = scan.scan.points.iter().filter(|p| p.ring == 32 && p.column.abs_diff(column) < 3);
        near.map(|p| f64::from(p.intensity)).fold(0.0, f64::max)
    };
    // 3 m ahead, 2 m to the right: by the inverse square, less within the 5 m of its focus.
    let ratio = at(64) / at(0);
    let want = (9.0 + 25.0) / (4.0 + 25.0);
    assert!((ratio / want - 1.0).abs() < 0.15, "{ratio} for {want}");
}

#[test]
fn truth_an_edge_in_a_beam_gives_two_returns() {
    if skipped() {
        return;
    }
    let mut scene = room_with_lidar();
    scene.boxes.push(a_box([1.25, 0.5, 1.0], [0.5, 1.0, 2.0]));
    for (returns, types) in [
        (Returns::StrongestLast, [ReturnType::Last, ReturnType::StrongestOrSecond]),
        (Returns::FirstLast, [ReturnType::Last, ReturnType::First]),
    ] {
        scene.lidar.as_mut().unwrap().returns = returns;
        let scan = scan_of(&scene);
        let twice: Vec<_> = scan
            .scan
            .points
            .windows(2)
            .filter(|p| p[0].column == p[1].column && p[0].ring == p[1].ring)
            .collect();
        assert!(!twice.is_empty() && twice.len() < 200, "{}", twice.len());
        for pair in twice {
            assert_eq!([pair[0].return_type, pair[1].return_type], types);
            let ranges = [pair[0], pair[1]].map(|p| f64::from(p.x_m).hypot(p.y_m.into()).hypot(p.z_m.into()));
            assert!(ranges[0] > ranges[1] + 0.9, "the last lies behind: {ranges:?}");
        }
    }
    scene.lidar.as_mut().unwrap().returns = Returns::Strongest;
    let scan = scan_of(&scene);
    assert_eq!(scan.truth.len(), scan.beams as usize);
    assert!(scan.scan.points.iter().all(|point| point.return_type == ReturnType::Single));
}

#[test]
fn truth_a_robot_that_drives_gives_points_of_their_own_time() {
    if skipped() {
        return;
    }
    let scene = room_with_lidar();
    let mut simulator = LidarSimulator::with_context(&scene, &context()).unwrap();
    let way = |share: f64| robot(-1.0 + 2.0 * share, 0.0, 0.5 * share);
    let scan = simulator.scan(0, 0, way).unwrap();
    let mut off_when_still = 0;
    for (point, _) in pairs(&scan) {
        let share = f64::from(point.time_s) / 0.025;
        assert!(off_the_room(in_map(&scene, way(share), point)) < NOISE_M, "{point:?}");
        off_when_still += u32::from(off_the_room(in_map(&scene, way(0.0), point)) > 0.3);
    }
    assert!(off_when_still > 1000, "the control: {off_when_still}");
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_other_noise() {
    if skipped() {
        return;
    }
    let mut scene = room_with_lidar();
    let first = scan_of(&scene);
    assert_eq!(scan_of(&scene), first);
    scene.seed += 1;
    let other = scan_of(&scene);
    assert_ne!(other.scan.points, first.scan.points);
    assert_eq!(other.scan.points.len(), first.scan.points.len());
}

#[test]
fn every_sensor_scans_the_room() {
    if skipped() {
        return;
    }
    for model in LidarModel::ALL {
        let mut scene = room_with_lidar();
        scene.lidar = Some(Lidar { model, rate_hz: 40.0, ..Lidar::default() });
        let scan = scan_of(&scene);
        let rings: HashSet<u16> = scan.scan.points.iter().map(|point| point.ring).collect();
        assert_eq!(rings.len(), model.optics().rings.len(), "{model:?}");
        let share = scan.truth.len() as f64 / f64::from(scan.beams);
        assert!(share > 0.95 && share < 1.05, "{model:?}: {share}");
    }
}
