//! Scans that are empty, too large, without what is asked for, or not numbers.

use crate::support::scan::{ScanFrame, ScanOptions, ScanPipeline};
use glam::{DQuat, DVec3};
use limpid::base::Rigid;
use limpid::config::MAX_POINTS;
use limpid::config::{PlaneSource, Solidity};
use limpid::map::CellClass;
use limpid::sensor::{BeamGrid, Point, SensorPose};
use limpid::stage::lidar::planes::plane_rings;
use limpid::{Config, Error};

use crate::support::gpu::skipped;
use crate::support::random::Random;
use crate::support::scan::{cell, open, point, posed, run_one, scan, step, still};

fn refused(config: &Config, frame: &ScanFrame, part: &str) {
    let error = ScanPipeline::open(config, frame, &ScanOptions::default()).err().unwrap().to_string();
    assert!(error.contains(part), "{error}");
}

#[test]
fn no_points_leave_everything_unknown() {
    if skipped() {
        return;
    }
    let out = run_one(&Config::default(), &still(scan(0, Vec::new())));
    assert_eq!(out.count(CellClass::Unknown), 200 * 200);
    assert!(out.costmap.iter().all(|&cost| cost == 255));
}

#[test]
fn a_million_points_work_and_one_more_than_fits_is_refused_by_number() {
    if skipped() {
        return;
    }
    // All in one cell at full scale: the largest sum there can be.
    let points = vec![point([1.05, 1.05, 0.2], 255.0); MAX_POINTS as usize];
    let small = still(scan(0, points[..100].to_vec()));
    let config = Config { max_points: MAX_POINTS, ..Config::default() };
    let mut pipeline = open(&config, &small);
    let out = step(&mut pipeline, &still(scan(1, points.clone())));
    assert_eq!((out.points, out.count(CellClass::Solid)), (MAX_POINTS as usize, 1));
    let high = out.layers.unwrap().grids.iter().find(|g| g.0 == "intensity_1").unwrap().1.clone();
    assert!((high.iter().copied().fold(0.0, f32::max) - 1.0).abs() < 1e-6, "the mean is exact");
    let more = still(scan(2, [points, vec![point([1.0, 0.0, 0.0], 1.0)]].concat()));
    refused(&config, &more, "1048577 points; at most 1048576");
    let error = pipeline.submit(&more).unwrap_err();
    assert!(matches!(error, Error::Input { .. }), "{error}");
    assert_eq!(step(&mut pipeline, &small).points, 100, "and the next one works");
}

#[test]
fn what_the_first_scan_lacks_is_named() {
    let bare = still(scan(0, vec![point([1.0, 0.0, 0.0], 0.0); 20]));
    let rings = Config { plane_source: PlaneSource::Rings, ..Config::default() };
    refused(&rings, &bare, "plane_source rings needs two");
    refused(&Config { gamma: Some(-1.0), ..Config::default() }, &bare, "gamma");
}

#[test]
fn numbers_that_are_no_rings_are_not_taken_for_them() {
    // Each of four lasers draws a rosette over 50 degrees of elevation; then each is a ring of its own.
    let scan_of = |elevation: fn(f64) -> f64| {
        let points = (0..400_u16).map(|at| {
            let (turn, up) = (f64::from(at) * 0.05, elevation(f64::from(at)));
            Point { ring: at % 4, ..point([3.0 * turn.cos(), 3.0 * turn.sin(), 3.0 * up.tan()], 90.0) }
        });
        scan(0, points.collect())
    };
    let rosette = scan_of(|at| (at * 0.37).sin() * 0.45);
    let rings = scan_of(|at| 0.03 * (at % 4.0) - 0.04);
    let config = Config::default();
    assert_eq!(plane_rings(&config, &rosette).unwrap(), None);
    assert_eq!(plane_rings(&config, &rings).unwrap(), Some([1, 0]));
    assert!(!BeamGrid::of_scan(&rosette).unwrap().by_ring && BeamGrid::of_scan(&rings).unwrap().by_ring);
    let by_rings = Config { plane_source: PlaneSource::Rings, ..config };
    let error = plane_rings(&by_rings, &rosette).unwrap_err().to_string();
    assert!(error.contains("0 rings of steady elevation"), "{error}");
}

#[test]
fn the_full_scale_of_a_percentile_is_reported() {
    if skipped() {
        return;
    }
    let points: Vec<Point> = (0..=100).map(|i| point([1.05, 0.05, 0.2], f64::from(i))).collect();
    let config = Config {
        intensity_full_scale: 0.0,
        intensity_percentile: 90.0,
        solidity: Solidity::Intensity,
        ..Config::default()
    };
    let notes = open(&config, &still(scan(0, points))).mapper.notes();
    assert!(notes[0].contains("intensities: 90 (percentile 90"), "{notes:?}");
}

#[test]
fn a_pose_that_is_missing_or_no_number_is_refused_and_the_map_stays() {
    if skipped() {
        return;
    }
    let good = still(scan(0, vec![point([1.05, 0.05, 0.2], 255.0)]));
    let mut pipeline = open(&Config::default(), &good);
    let before = step(&mut pipeline, &good);
    for pose in [
        None,
        good.pose.map(|mut pose| {
            pose.map_from_base.translation_m.x = f64::NAN;
            pose
        }),
    ] {
        let error = pipeline.submit(&ScanFrame { pose, ..good.clone() }).unwrap_err().to_string();
        assert!(error.contains("no transform from map") || error.contains("not finite"), "{error}");
    }
    assert_eq!(step(&mut pipeline, &good).classes, before.classes);
}

#[test]
fn the_same_scans_give_the_same_bits() {
    if skipped() {
        return;
    }
    let mut random = Random(3);
    let mut place = || f64::from(random.unit()) * 16.0 - 8.0;
    let points: Vec<Point> = (0..5000)
        .map(|i| {
            let at = [place(), place(), place() / 16.0];
            Point { ring: i % 16, ..point(at, 15.0 * (place() + 8.0)) }
        })
        .collect();
    let frame = still(scan(0, points));
    let (a, b) = (run_one(&Config::default(), &frame), run_one(&Config::default(), &frame));
    assert_eq!(a, b);
    assert!(a.count(CellClass::Solid) > 100);
}

#[test]
fn a_pose_that_jumps_is_counted_and_the_scan_is_used() {
    if skipped() {
        return;
    }
    let frame = |index: u64, x_m: f64, turned_deg: f64| {
        let rotation = DQuat::from_rotation_z(turned_deg.to_radians());
        let map_from_base = Rigid { rotation, translation_m: DVec3::new(x_m, 0.0, 0.0) };
        let pose = SensorPose { map_from_base, base_from_sensor: Rigid::IDENTITY, sweep: None };
        posed(scan(index, vec![point([1.05, 1.05, 0.2], 255.0)]), pose)
    };
    // At 10 Hz 1 m and 36 degrees a scan are the most; a scan that repeats the stamp, or goes back, has as much.
    let drive = [
        (0, 50.0, 90.0, false, "the first"),
        (1, 50.9, 90.0, false, "9 m/s"),
        (2, 52.0, 90.0, true, "11 m/s"),
        (3, 52.0, 125.0, false, "350 degrees/s"),
        (4, 52.0, 165.0, true, "400 degrees/s"),
        (5, 52.0, -195.0, false, "the same heading by another number"),
        (15, 61.0, -195.0, false, "9 m within a second without scans"),
        (14, 61.5, -195.0, false, "a stamp that goes back"),
        (14, 63.0, -195.0, true, "back, and too far"),
    ];
    let jumps = |config: &Config| -> Vec<bool> {
        let mut pipeline = open(config, &frame(0, 50.0, 90.0));
        drive
            .iter()
            .map(|&(index, x_m, deg, ..)| {
                let out = step(&mut pipeline, &frame(index, x_m, deg));
                let seen = DQuat::from_rotation_z(deg.to_radians()) * DVec3::new(1.05, 1.05, 0.2);
                let at = cell(&out, x_m + seen.x, seen.y);
                assert_eq!(out.classes[at], CellClass::Solid as u8, "the scan is used");
                out.pose_jumped
            })
            .collect()
    };
    let found = jumps(&Config::default());
    for (found, (_, _, _, wanted, what)) in found.into_iter().zip(drive) {
        assert_eq!(found, wanted, "{what}");
    }
    let off = Config { pose_jump_m_s: 0.0, pose_jump_deg_s: 0.0, ..Config::default() };
    assert_eq!(jumps(&off), [false; 9]);
}
