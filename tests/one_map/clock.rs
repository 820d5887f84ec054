//! Stamps that lie far ahead, that jump back, and that come late.

use limpid::base::Refused;
use limpid::map::State;
use limpid::mapper::SensorInfo;
use limpid::sensor::Observation;

use super::rig::{
    FRAME_MS, FRAMES, Rig, at_ms, camera_and_lidar, config, dim_wall, frame, mount, room, sweep, two_cameras,
};
use crate::support::gpu::skipped;
use crate::support::scene::{Block, Scene, small_camera};

const FRONT: usize = 0;
const REAR: usize = 1;
const POST: [f64; 2] = [1.52, 0.02];
const FLOOR: [f64; 2] = [1.12, 0.02];

fn with_post() -> Scene {
    room(&[Block::new([1.513, -0.4, 0.0], [1.6, 0.4, 0.5])])
}

/// Both cameras look ahead, so that they see the same cells.
fn look(sensor: usize, ms: u64, scene: &Scene) -> Observation {
    frame(sensor, ms, scene, small_camera(), mount(0.0, 0.2))
}

fn rig() -> Rig {
    let config = config();
    Rig::open(&config, &two_cameras(&config))
}

#[test]
fn truth_a_stamp_30_s_ahead_is_refused_until_the_fourth_in_a_row() {
    if skipped() {
        return;
    }
    let mut rig = rig();
    [FRONT, REAR].into_iter().for_each(|sensor| drop(rig.see(&look(sensor, 0, &with_post()))));
    let ahead = |rig: &mut Rig, ms: u64| rig.refuse(&look(REAR, ms + 30_000, &with_post()));
    for round in 1..=3 {
        // Three ahead, and then a good one: they are counted anew.
        for index in 0..3 {
            let ms = 100 * round + 10 * index;
            assert_eq!(ahead(&mut rig, ms), Refused::Ahead { ahead_s: 30 }, "round {round}");
            rig.see(&look(FRONT, ms + 5, &with_post()));
            let out = rig.publish(None);
            assert_eq!((out.stamp_ns, out.map.state), (at_ms(ms + 5), State::Ok), "the other goes on");
        }
        rig.see(&look(REAR, 100 * round + 50, &with_post()));
    }
    // Without one between, the fourth is believed: it is the other that is behind then.
    for index in 0..3 {
        assert!(matches!(ahead(&mut rig, 400 + index), Refused::Ahead { .. }));
    }
    rig.see(&look(REAR, 30_403, &with_post()));
    let out = rig.publish(None);
    assert_eq!((out.stamp_ns, &out.map.sensors[..]), (at_ms(30_403), &[State::Stale, State::Ok][..]));
}

#[test]
fn a_sensor_alone_in_the_map_s_time_is_believed_at_once() {
    if skipped() {
        return;
    }
    let mut rig = rig();
    rig.see(&look(FRONT, 0, &with_post()));
    rig.see(&look(FRONT, 30_000, &with_post()));
    assert_eq!(rig.publish(None).stamp_ns, at_ms(30_000), "nobody says otherwise");
}

#[test]
fn truth_stamps_that_jump_back_go_on_from_the_map_s_time() {
    if skipped() {
        return;
    }
    let mut rig = rig();
    let start_ms = 100_000;
    for index in 0..FRAMES {
        rig.see(&look(FRONT, start_ms + index * FRAME_MS, &room(&[])));
        rig.see(&look(REAR, start_ms + index * FRAME_MS, &room(&[])));
    }
    let before = rig.publish(None);
    let last_ms = start_ms + (FRAMES - 1) * FRAME_MS;
    assert_eq!((before.stamp_ns, before.said(POST)), (at_ms(last_ms), (9, 0)));
    // Its clock is set back by a minute; what it sees is new all the same.
    for index in 0..FRAMES {
        rig.see(&look(FRONT, last_ms - 60_000 + index * FRAME_MS, &with_post()));
        let out = rig.publish(None);
        assert_eq!(out.stamp_ns, at_ms(last_ms + index * FRAME_MS), "the map's time goes on");
        assert_eq!(out.map.state, State::Ok);
    }
    let out = rig.publish(None);
    assert_eq!((out.said(POST), out.verdict(POST).sensor()), ((6, 254), Some(FRONT)));
    assert!(out.verdict(POST).age_s().abs() < 1e-9);
    // The other, whose clock is as it was, is no later than it is.
    rig.see(&look(REAR, last_ms + 300, &with_post()));
    let out = rig.publish(None);
    assert_eq!((out.stamp_ns, out.map.state), (at_ms(last_ms + 300), State::Ok));
    assert!(out.of(9, REAR).len() > 1000);
}

#[test]
fn truth_a_late_frame_changes_no_cell_that_was_seen_since() {
    if skipped() {
        return;
    }
    let mut rig = rig();
    for index in 0..FRAMES {
        rig.see(&look(FRONT, 300 + index * FRAME_MS, &room(&[])));
    }
    let before = rig.publish(None);
    // Ten frames of the other, with a post where the first saw none, all older.
    for index in 0..FRAMES {
        rig.see(&look(REAR, index * 20, &with_post()));
    }
    let after = rig.publish(None);
    assert_eq!(after.stamp_ns, before.stamp_ns);
    assert_eq!(after.map.verdicts, before.map.verdicts, "the same cells were seen since");
    // To the side it saw others, which take what is late.
    for index in 0..FRAMES {
        let yaw = 0.5 * std::f64::consts::PI;
        let side = room(&[Block::new([-0.4, 1.513, 0.0], [0.4, 1.6, 0.5])]);
        rig.see(&frame(REAR, index * FRAME_MS, &side, small_camera(), mount(yaw, 0.2)));
    }
    let out = rig.publish(None);
    assert_eq!((out.said([0.02, 1.52]), out.said([0.02, 1.12])), ((6, 254), (9, 0)));
    assert!((out.verdict([0.02, 1.12]).age_s() - 0.3).abs() < 0.011);
    assert_eq!(out.said(FLOOR), before.said(FLOOR));
    // The control: the same post, seen later, is marked.
    for index in 0..FRAMES {
        rig.see(&look(REAR, 600 + index * FRAME_MS, &with_post()));
    }
    assert_eq!(rig.publish(None).said(POST), (6, 254));
}

#[test]
fn truth_a_late_scan_changes_no_cell_that_was_scanned_since() {
    if skipped() {
        return;
    }
    let config = config();
    let camera_and_lidar = camera_and_lidar(&config);
    let second = SensorInfo { name: "second".into(), ..camera_and_lidar[1].clone() };
    let [camera, lidar] = camera_and_lidar;
    let mut rig = Rig::open(&config, &[camera, lidar, second]);
    let far = dim_wall(2.52, -0.5..0.5, 0.7);
    let near: Vec<_> = dim_wall(1.52, -0.5..0.5, 0.7).into_iter().map(|(at, _)| (at, 200.0)).collect();
    rig.see(&sweep(1, 500, &far));
    assert_eq!(rig.publish(None).said(POST), (8, 0));
    rig.see(&sweep(2, 100, &near));
    let out = rig.publish(None);
    assert_eq!([out.said(POST), out.said([2.52, 0.02])], [(8, 0), (7, 50)]);
    assert_eq!(out.said([1.52, 0.42]), (2, 254), "where the newer one says nothing, the late one is used");
    rig.see(&sweep(2, 501, &near));
    assert_eq!(rig.publish(None).said(POST), (2, 254), "the control");
}
