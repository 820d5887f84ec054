//! Scans with poses and goals out of a recording.

use std::path::Path;

use crate::support::scan::{ScanFrame, ScanOutput};
use glam::{DQuat, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::config::StaticTransform;
use limpid::input::PosedScans;
use limpid::map::CellClass;
use limpid::output::save_scan;
use limpid::sensor::SensorPose;
use limpid::sensor::{Columns, Point, Scan};

use crate::support::data_dir;
use crate::support::gpu::skipped;
use crate::support::scan::{cell, point, run_one, scan};

fn save(folder: &Path, name: &str, scan: &Scan) {
    save_scan(&folder.join(name), scan).unwrap();
}

fn first(path: &Path, config: &Config) -> ScanFrame {
    PosedScans::open(path, config).unwrap().next_observation().unwrap().unwrap().into()
}

#[test]
fn without_poses_the_map_is_the_lidar_s_own_frame() {
    let folder = tempfile::tempdir().unwrap();
    save(folder.path(), "a.ply", &scan(0, vec![Point { ring: 0, ..point([1.0, 0.0, 0.0], 9.0) }]));
    let frame = first(folder.path(), &Config { lidar_frame: "roof".into(), ..Config::default() });
    assert_eq!((frame.map_frame.as_str(), frame.pose), ("roof", Some(SensorPose::SENSOR)));
}

#[test]
fn stated_transforms_place_the_scans_of_files() {
    let folder = tempfile::tempdir().unwrap();
    save(folder.path(), "a.ply", &scan(0, vec![Point { ring: 0, ..point([1.0, 0.0, 0.0], 9.0) }]));
    let stated = |parent: &str, child: &str, x: f64| StaticTransform {
        parent: parent.into(),
        child: child.into(),
        translation_m: [x, 0.0, 0.5],
        rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
    };
    let static_transforms = vec![stated("map", "base_link", 3.0), stated("base_link", "roof", 0.25)];
    let config = Config { lidar_frame: "roof".into(), static_transforms, ..Config::default() };
    let frame = first(folder.path(), &config);
    let pose = frame.pose.unwrap();
    assert_eq!(frame.map_frame, "map");
    assert_eq!(pose.map_from_base.translation_m, DVec3::new(3.0, 0.0, 0.5));
    assert_eq!(pose.map_from_sensor().translation_m, DVec3::new(3.25, 0.0, 1.0));
    let unknown = Config { lidar_frame: "cellar".into(), ..config };
    let mut scans = PosedScans::open(folder.path(), &unknown).unwrap();
    assert_eq!(scans.next_observation().unwrap().unwrap().pose, None);
    assert!(scans.report().read.skipped[0].reason.contains("`cellar`"));
}

#[test]
fn three_d_ref_has_its_lidar_in_the_map() {
    let Some(path) = data_dir("lidar/3dref.mcap") else { return };
    let mut scans = PosedScans::open(&path, &Config::default()).unwrap();
    let mut poses = Vec::new();
    while let Some(frame) = scans.next_observation().unwrap().map(ScanFrame::from) {
        assert_eq!(frame.map_frame, "map");
        poses.push(frame.pose.unwrap().map_from_sensor().translation_m);
    }
    assert_eq!(poses.len(), 6);
    assert!((poses[0] - DVec3::new(0.042_454, -0.002_902, 0.261_928)).length() < 1e-5, "{:?}", poses[0]);
}

#[test]
fn truth_a_revolution_on_the_move_is_deskewed() {
    if skipped() {
        return;
    }
    // A wall at x = 3 m of the map; the lidar drives 1 m and turns by 30 degrees during one revolution.
    let moves = |share: f64| Rigid {
        rotation: DQuat::from_rotation_z(30_f64.to_radians() * share),
        translation_m: DVec3::new(share, 0.0, 0.0),
    };
    let points: Vec<Point> = (0..400_u16)
        .map(|i| {
            let share = f64::from(i) / 399.0;
            let wall = DVec3::new(3.05, f64::from(i) * 0.01 - 1.995, 0.2);
            let seen = moves(share).inverse().transform_point(wall);
            Point { time_s: (0.1 * share) as f32, ..point(seen.to_array(), 255.0) }
        })
        .collect();
    let columns = Columns { time: true, ..Columns::default() };
    let scan = Scan { columns, ..scan(0, points) };
    let sweep = limpid::sensor::Sweep {
        first_s: 0.0,
        last_s: 0.1,
        map_from_first: moves(0.0),
        map_from_last: moves(1.0),
    };
    let pose = SensorPose { sweep: Some(sweep), ..SensorPose::SENSOR };
    let frame = ScanFrame { scan, map_frame: "map".into(), pose: Some(pose), goal_m: None };
    let out = run_one(&Config::default(), &frame);
    let wall = |out: &ScanOutput| {
        let at = |row: i32| cell(out, 3.05, f64::from(row) * 0.1 - 1.95);
        (0..40).filter(|&row| out.classes[at(row)] == CellClass::Solid as u8).count()
    };
    assert_eq!((wall(&out), out.count(CellClass::Solid)), (40, 40));
    let skewed = run_one(&Config { deskew: false, ..Config::default() }, &frame);
    assert!(wall(&skewed) < 20, "the control: without deskewing the wall is bent");
}
