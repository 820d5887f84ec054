//! Panes that a lidar knows, and cameras that look through them: row 1 of the rule, and what lies beyond.

use glam::{DQuat, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::mapper::SensorInfo;
use limpid::sensor::{DepthImage, DepthSamples, Observation, RgbdFrame, Scan, SensorData, SensorPose};

use super::rig::{Published, Rig, at_ms, camera, config as still_config, mount};
use crate::support::glass_room::{GlassRoom, WALL_X_M};
use crate::support::gpu::skipped;
use crate::support::scene::{Block, Scene, small_camera};

const CAMERA: usize = 0;
const LIDAR: usize = 1;

/// Height of the room's middle above its floor.
const FLOOR_M: f64 = 1.2;
/// Places on the pane, and the same beyond it on the floor, where the camera sees through.
const ON_PANE: [f64; 5] = [-1.0, -0.5, 0.0, 0.7, 1.1];
/// A floor beyond, and a thing on it.
const THING_X_M: f64 = 6.02;

fn config() -> Config {
    // Beams leave the layers within a metre: those that go through the pane free nothing beyond it.
    let layer_heights_m = vec![-0.01, 0.01];
    let (map_size_m, mark_range_m, range_gate_m) = (16.0, 7.5, 9.0);
    Config {
        layer_heights_m,
        map_size_m,
        mark_range_m,
        range_gate_m,
        resolution_m: 0.1,
        glass: true,
        deskew: false,
        ..still_config()
    }
}

fn glass_room(glass: bool) -> GlassRoom {
    GlassRoom { glass, yaw: 0.0, ..GlassRoom::default() }
}

/// The sensors stand where the lidar of the room does.
fn map_from_base(room: &GlassRoom) -> Rigid {
    Rigid { rotation: DQuat::IDENTITY, translation_m: DVec3::new(room.sensor_m.x, room.sensor_m.y, 0.0) }
}

fn scan_of(room: &GlassRoom, ms: u64) -> Scan {
    Scan { index: ms, stamp_ns: at_ms(ms), ..room.scan().0 }
}

fn scan(room: &GlassRoom, ms: u64) -> Observation {
    let base_from_sensor = Rigid { rotation: DQuat::IDENTITY, translation_m: DVec3::Z * FLOOR_M };
    Observation {
        sensor: LIDAR,
        pose: Some(SensorPose { map_from_base: map_from_base(room), base_from_sensor, sweep: None }),
        map_frame: "map".into(),
        goal_m: None,
        data: SensorData::Scan(scan_of(room, ms)),
    }
}

/// The frame below the pane, the walls beside it, and a low box on the floor beyond: what a camera to which glass is nothing
/// sees.
fn scene() -> Scene {
    Scene::of(&[
        Block::new([WALL_X_M, -3.5, 0.0], [WALL_X_M + 0.09, 3.5, 0.3]),
        Block::new([WALL_X_M, -3.5, 0.0], [WALL_X_M + 0.09, -2.0, 3.0]),
        Block::new([WALL_X_M, 2.0, 0.0], [WALL_X_M + 0.09, 3.5, 3.0]),
        Block::new([THING_X_M, -0.35, 0.0], [THING_X_M + 0.3, 0.35, 0.8]),
    ])
}

fn frame(room: &GlassRoom, ms: u64) -> Observation {
    let mount = mount(0.0, 0.15);
    let base_from_sensor = Rigid { translation_m: DVec3::Z * FLOOR_M, ..mount };
    let pose = SensorPose { map_from_base: map_from_base(room), base_from_sensor, sweep: None };
    let depth = small_camera();
    let samples = DepthSamples::Metres(scene().depth(&depth, pose.map_from_sensor()));
    let frame_id = "camera".into();
    let image = DepthImage { stamp_ns: at_ms(ms), frame_id, camera: depth, samples };
    let (color, color_from_depth, confidence) = (None, None, None);
    let frame = RgbdFrame {
        index: ms,
        depth: image,
        color,
        color_from_depth,
        color_missing: None,
        confidence,
        pose: None,
    };
    Observation { pose: Some(pose), ..Observation::of_frame(CAMERA, "map", frame) }
}

/// Maps after a scan or none, and after ten frames of the camera then.
fn look(room: &GlassRoom, with_scan: bool) -> [Option<Published>; 2] {
    let config = config();
    let lidar = SensorInfo { name: "top".into(), ..SensorInfo::lidar(&config, scan_of(room, 0)) };
    let mut rig = Rig::open(&config, &[camera("front", &config, small_camera(), false), lidar]);
    let first = with_scan.then(|| {
        rig.see(&scan(room, 0));
        rig.publish(None)
    });
    for index in 0..10 {
        rig.see(&frame(room, 33 + 33 * index));
    }
    [first, Some(rig.publish(None))]
}

#[test]
fn truth_a_pane_is_glass_and_a_camera_neither_clears_it_nor_sees_beyond() {
    if skipped() {
        return;
    }
    let [before, after] = look(&glass_room(true), true).map(Option::unwrap);
    let [_, without] = look(&glass_room(true), false);
    let without = without.unwrap();
    for y_m in ON_PANE {
        let pane = [WALL_X_M + 0.02, y_m];
        for out in [&before, &after] {
            assert_eq!(out.said(pane), (1, 254), "y = {y_m}");
            assert_eq!(out.verdict(pane).sensor(), Some(LIDAR));
        }
        assert!((after.verdict(pane).age_s() - 0.3).abs() < 1e-9, "{}", after.verdict(pane).age_s());
    }
    let beyond = |cell: &usize| {
        let [x_m, y_m] = after.centre(*cell);
        x_m > WALL_X_M + 0.2 && x_m < 7.5 && y_m.abs() < 1.5
    };
    let cells: Vec<usize> = (0..after.map.verdicts.len()).filter(beyond).collect();
    let rows =
        |out: &Published, row: u32| cells.iter().filter(|&&cell| out.map.verdicts[cell].row() == row).count();
    assert_eq!(rows(&before, 10), cells.len(), "nothing mirrored is in the lidar's map");
    assert_eq!(rows(&after, 10), cells.len(), "the camera marks nothing beyond the pane, and frees nothing");
    // The control: without the scan the same frames free the floor there, and mark the box on it.
    assert!(rows(&without, 9) > cells.len() / 3, "{} of {}", rows(&without, 9), cells.len());
    assert!(rows(&without, 6) >= 6, "{}", rows(&without, 6));
    assert_eq!(without.said([THING_X_M + 0.01, 0.02]), (6, 254));
    assert!(look(&glass_room(true), true)[1].as_ref() == Some(&after), "the same messages, the same bits");
    // Before the pane the camera frees the floor in both.
    let near = [2.55, 0.25];
    assert_eq!([without.said(near), after.said(near)].map(|said| said.1), [0; 2]);
}

#[test]
fn truth_a_wall_in_place_of_the_pane_is_no_glass() {
    if skipped() {
        return;
    }
    let [before, after] = look(&glass_room(false), true).map(Option::unwrap);
    for out in [before, after] {
        assert!(out.map.verdicts.iter().all(|verdict| verdict.row() != 1));
    }
}
