//! Recordings of simulated cameras: limpid's own readers take them, the truth comes back, the methods run.

use std::path::Path;

use limpid::config::Method;
use limpid::input;
use limpid::mapper::Options;
use limpid::run::run;
use limpid::sensor::DepthSamples;
use limpid::sim::Simulator;
use limpid::sim::frame::SimFrame;
use limpid::sim::truth::{OCCUPIED, TrueMap, TruthReader};
use limpid::sim::write::recorder;
use limpid::{Config, Error};

use super::small_room;
use crate::support::gpu::skipped;

const FRAMES: u32 = 12;

/// Drives through the room and records it; the frames with their true cells.
fn record(path: &Path) -> Vec<(SimFrame, Vec<i8>)> {
    let mut scene = small_room();
    scene.trajectory.waypoints_m = vec![[-1.0, 0.0], [0.5, 0.3]];
    scene.trajectory.frames = FRAMES;
    scene.camera.baseline_m = 0.3;
    let mut simulator = Simulator::open(&scene, None, false).unwrap();
    let mut recorder = recorder(path, &scene, true).unwrap();
    let mut map = TrueMap::new(&scene, &Config::default());
    let poses = simulator.poses();
    let mut frames = Vec::new();
    for (index, &pose) in (0..).zip(&poses) {
        let frame = simulator.frame(index, pose).unwrap();
        map.observe(&frame, &scene.camera.model());
        recorder.write(&frame, &map.grid(), &map.cells()).unwrap();
        frames.push((frame, map.cells()));
    }
    recorder.finish().unwrap();
    frames
}

fn comes_back(path: &Path, written: &[(SimFrame, Vec<i8>)]) {
    let mut reader = input::open(path, &Config::default()).unwrap();
    let mut truth = TruthReader::open(path).unwrap();
    for (frame, cells) in written {
        let read = reader.next_frame().unwrap().unwrap();
        assert_eq!(read.depth.stamp_ns, frame.stamp_ns);
        assert_eq!(read.depth.samples, DepthSamples::Integer { raw: frame.depth_mm.clone(), unit_m: 0.001 });
        assert_eq!(read.color.as_ref().unwrap().rgb, frame.rgb);
        assert!(read.color_is_aligned());
        let pose = read.pose.unwrap();
        let got = pose.map_from_base.then(pose.base_from_camera);
        let want = frame.pose.map_from_base.then(frame.pose.base_from_camera);
        assert!(got.translation_m.distance(want.translation_m) < 1e-9);
        assert!(got.rotation.angle_between(want.rotation) < 1e-6);
        let true_frame = truth.next_frame().unwrap().unwrap();
        assert_eq!(truth.scene().unwrap().unwrap().rooms, small_room().rooms);
        assert_eq!(true_frame.stamp_ns, frame.stamp_ns);
        assert_eq!(true_frame.depth_m, frame.true_depth_m);
        assert_eq!(true_frame.material, frame.material);
        assert_eq!(&true_frame.cells, cells);
        assert!((true_frame.grid.resolution_m - 0.05).abs() < 1e-12 && true_frame.grid.width > 100);
    }
    assert!(reader.next_frame().unwrap().is_none() && truth.next_frame().unwrap().is_none());
    assert!(reader.report().skipped.is_empty(), "{:?}", reader.report().skipped);
}

#[test]
fn recordings_come_back_and_the_methods_run_on_them() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mcap = folder.path().join("drive.mcap");
    let written = record(&mcap);
    assert_eq!(written.len(), FRAMES as usize);
    comes_back(&mcap, &written);
    let again = folder.path().join("again.mcap");
    record(&again);
    assert_eq!(
        std::fs::read(&mcap).unwrap(),
        std::fs::read(&again).unwrap(),
        "the same seed, the same bytes"
    );
    let config = Config { method: Method::Naive, ..Config::default() };
    let mut source = input::open_source(&mcap, &config).unwrap();
    let report =
        run(source.as_mut(), 0..u64::MAX, &config, &Options::default(), &mut [], &mut |_| {}).unwrap();
    assert_eq!((report.taken(), report.sensors[0].without_pose), (u64::from(FRAMES), 0));
    // The map's obstacles are where the truth has them, a cell more or less.
    let last = report.last().unwrap();
    let (truth, map) = (last_truth(&mcap), last.map.as_ref().unwrap().grid);
    let lethal =
        (0..map.width * map.height).filter(|&i| last.map.as_ref().unwrap().costmap[i as usize] == 254);
    let (mut near, mut all) = (0, 0);
    for cell in lethal {
        let x = map.origin_x_m + f64::from(cell % map.width) * map.resolution_m;
        let y = map.origin_y_m + f64::from(cell / map.width) * map.resolution_m;
        let column = ((x - truth.grid.origin_x_m) / 0.05).round() as i64;
        let row = ((y - truth.grid.origin_y_m) / 0.05).round() as i64;
        let occupied = |dx: i64, dy: i64| {
            let index = (row + dy) * i64::from(truth.grid.width) + column + dx;
            truth.cells.get(index as usize) == Some(&OCCUPIED)
        };
        all += 1;
        near += i32::from((-3..=3).any(|dx| (-3..=3).any(|dy| occupied(dx, dy))));
    }
    assert!(all > 20 && near * 10 > all * 8, "{near} of {all} lethal cells are near true obstacles");
}

fn last_truth(path: &Path) -> limpid::sim::truth::TruthFrame {
    let mut reader = TruthReader::open(path).unwrap();
    let mut last = None;
    while let Some(frame) = reader.next_frame().unwrap() {
        last = Some(frame);
    }
    last.unwrap()
}

#[test]
fn folders_come_back() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drive");
    let written = record(&path);
    comes_back(&path, &written);
    assert!(path.join("truth/scene.yaml").exists() && path.join("infra2/000003.png").exists());
    // Damage is named.
    std::fs::write(path.join("truth.txt"), "1.5 only two\n").unwrap();
    let error = TruthReader::open(&path).err().unwrap();
    assert!(matches!(&error, Error::Format { reason, .. } if reason.contains("only two")), "{error}");
}

#[test]
fn recordings_without_truth_have_none() {
    let mut reader = TruthReader::open("testdata/room.mcap".as_ref()).unwrap();
    assert!(reader.next_frame().unwrap().is_none());
    assert!(matches!(TruthReader::open("Cargo.toml".as_ref()), Err(Error::Format { .. })));
    assert!(matches!(TruthReader::open("testdata".as_ref()), Err(Error::File { .. })));
}
