//! Sensors that end, that come back, and that never came.

use limpid::base::Refused;
use limpid::config::{SensorConfig, SensorKind};
use limpid::map::State;
use limpid::mapper::SensorInfo;
use limpid::sensor::{DepthSamples, Observation, SensorData};
use std::f64::consts::PI;

use super::rig::{
    FRAME_MS, FRAMES, Published, Rig, at_ms, camera, config, frame, mount, room, sweep, two_cameras,
};
use crate::support::gpu::skipped;
use crate::support::scene::{Block, Scene, small_camera};

const FRONT: usize = 0;
const REAR: usize = 1;

/// A post before each camera.
fn scene() -> Scene {
    room(&[
        Block::new([1.513, -0.1, 0.0], [1.6, 0.1, 0.5]),
        Block::new([-1.6, -0.1, 0.0], [-1.513, 0.1, 0.5]),
    ])
}

fn look(sensor: usize, ms: u64) -> Observation {
    let yaw = if sensor == FRONT { 0.0 } else { PI };
    frame(sensor, ms, &scene(), small_camera(), mount(yaw, 0.2))
}

/// Both cameras until 297 ms.
fn both() -> Rig {
    let config = config();
    let mut rig = Rig::open(&config, &two_cameras(&config));
    for index in 0..FRAMES {
        [FRONT, REAR].into_iter().for_each(|sensor| drop(rig.see(&look(sensor, index * FRAME_MS))));
    }
    rig
}

/// The left half of what a camera sees.
fn left_half(observation: Observation) -> Observation {
    let SensorData::Frame(mut frame) = observation.data else { panic!("a scan") };
    let width = frame.depth.camera.width as usize;
    let DepthSamples::Metres(samples) = &mut frame.depth.samples else { panic!("counts") };
    samples
        .iter_mut()
        .enumerate()
        .filter(|(i, _)| i % width >= width / 2)
        .for_each(|(_, depth)| *depth = 0.0);
    Observation { data: SensorData::Frame(frame), ..observation }
}

fn count(cells: &[usize], out: &Published, row: u32) -> usize {
    cells.iter().filter(|&&cell| out.map.verdicts[cell].row() == row).count()
}

#[test]
fn truth_free_cells_of_a_camera_that_ended_are_unknown_and_come_back_as_they_are_seen() {
    if skipped() {
        return;
    }
    let mut rig = both();
    let before = rig.publish(None);
    assert_eq!((before.map.state, &before.map.sensors[..]), (State::Ok, &[State::Ok; 2][..]));
    let [front, rear] = [FRONT, REAR].map(|sensor| before.of(9, sensor));
    let posts = [FRONT, REAR].map(|sensor| before.of(6, sensor));
    assert!(front.len() > 1000 && rear.len() > 1000 && posts.iter().all(|cells| cells.len() > 3));

    // The front camera alone: every map up to the timeout has the rear's free cells, the first after it has none.
    let mut out = before.clone();
    for ms in (330..1000).step_by(33) {
        rig.see(&look(FRONT, ms));
        out = rig.publish(None);
        let stale = ms - 297 > 500;
        let state = if stale { State::Stale } else { State::Ok };
        assert_eq!((out.map.state, &out.map.sensors[..]), (state, &[State::Ok, state][..]), "{ms} ms");
        let rear_rows = if stale { [0, rear.len()] } else { [rear.len(), 0] };
        assert_eq!([9, 11].map(|row| count(&rear, &out, row)), rear_rows, "{ms} ms");
        assert_eq!(count(&front, &out, 9), front.len(), "{ms} ms");
    }
    assert!(rear.iter().all(|&cell| out.map.costmap[cell] == 255));
    for cells in &posts {
        assert_eq!(count(cells, &out, 6), cells.len(), "lethal cells stay");
    }

    // It comes back, and sees the half of what it saw: y < 0, as it looks back.
    rig.see(&left_half(look(REAR, 1000)));
    let back = rig.publish(None);
    assert_eq!(back.map.state, State::Ok);
    let seen = count(&rear, &back, 9);
    assert_eq!(seen + count(&rear, &back, 11), rear.len());
    assert!(seen > rear.len() / 4 && seen < 3 * rear.len() / 4, "{seen} of {}", rear.len());
    for &cell in &rear {
        let [_, y_m] = before.centre(cell);
        let row = back.map.verdicts[cell].row();
        assert!((row == 9) == (y_m < 0.0) || (y_m - 0.023).abs() < 0.1, "y = {y_m}: row {row}");
    }
    // And then all of it.
    rig.see(&look(REAR, 1033));
    assert_eq!(count(&rear, &rig.publish(None), 9), rear.len());
}

#[test]
fn truth_without_any_data_a_clock_makes_all_of_the_map_stale() {
    if skipped() {
        return;
    }
    let mut rig = both();
    let before = rig.publish(Some(297 + 500));
    assert_eq!(before.map.state, State::Ok, "not longer than the timeout");
    let out = rig.publish(Some(297 + 501));
    assert_eq!(out.stamp_ns, at_ms(297 + 501));
    assert_eq!((out.map.state, &out.map.sensors[..]), (State::Stale, &[State::Stale; 2][..]));
    for (was, is) in before.map.verdicts.iter().zip(&out.map.verdicts) {
        let row = if was.row() == 9 { 11 } else { was.row() };
        assert_eq!(is.row(), row);
        assert_eq!(is.cost(), if row == 6 { 254 } else { 255 });
    }
    // A clock that goes back does not make it fresh again.
    let again = rig.publish(Some(297 + 100));
    assert_eq!((again.stamp_ns, &again.map.verdicts), (out.stamp_ns, &out.map.verdicts));
}

#[test]
fn a_timeout_of_0_never_ends() {
    if skipped() {
        return;
    }
    let config = config();
    let sensors = two_cameras(&config).map(|sensor| SensorInfo { timeout_s: 0.0, ..sensor });
    let mut rig = Rig::open(&config, &sensors);
    [FRONT, REAR].into_iter().for_each(|sensor| drop(rig.see(&look(sensor, 0))));
    let out = rig.publish(Some(3_600_000));
    assert_eq!(out.map.state, State::Ok);
    assert!(out.of(9, FRONT).len() > 1000 && out.of(9, REAR).len() > 1000);
    let age_s = out.map.verdicts[out.of(9, FRONT)[0]].age_s();
    assert!((age_s - 3276.7).abs() < 1e-9, "the largest age that a verdict holds: {age_s}");
}

#[test]
fn truth_a_sensor_that_never_came_makes_the_map_stale_from_the_start() {
    if skipped() {
        return;
    }
    let config = config();
    for kind in [SensorKind::Lidar, SensorKind::Camera] {
        let named = SensorConfig { name: "absent".into(), ..SensorConfig::found(kind, &config) };
        let sensors = [camera("front", &config, small_camera(), false), SensorInfo::missing(named)];
        let mut rig = Rig::open(&config, &sensors);
        assert!(
            !rig.mapper.publish(Some(at_ms(0))).unwrap(),
            "nothing to publish before the first observation"
        );
        rig.see(&look(FRONT, 0));
        let out = rig.publish(None);
        assert_eq!((out.map.state, &out.map.sensors[..]), (State::Stale, &[State::Ok, State::Stale][..]));
        assert!(out.of(9, FRONT).len() > 1000, "the map of the other goes on");
        let late = if kind == SensorKind::Camera { look(1, 10) } else { sweep(1, 10, &[]) };
        let Refused::Sensor(reason) = rig.refuse(&late) else { panic!("another reason") };
        assert!(reason.contains("absent"), "{reason}");
        assert_eq!(rig.publish(None).map, out.map);
    }
}
