//! The map's state, and the age of single cells.

use std::f64::consts::PI;

use limpid::Config;
use limpid::map::State;
use limpid::sensor::DepthSamples;

use super::rig::{
    FRAMES, Rig, camera_and_lidar, config, dim_wall, frame, mount, of_samples, room, sweep, two_cameras,
};
use crate::support::gpu::skipped;
use crate::support::scene::{Block, small_camera};

#[test]
fn truth_the_map_s_state_is_the_worst_of_its_sensors() {
    if skipped() {
        return;
    }
    let config = config();
    let mut rig = Rig::open(&config, &two_cameras(&config));
    let mount = mount(0.0, 0.2);
    let good = |sensor, ms| frame(sensor, ms, &room(&[]), small_camera(), mount);
    // A frame of which more than half is holes is DEGRADED.
    let depth = room(&[]).depth(&small_camera(), super::rig::standing(mount).map_from_sensor());
    let half = |share: f64| {
        let least = (share * depth.len() as f64) as usize;
        let holed = depth.iter().enumerate().map(|(i, &depth)| if i < least { 0.0 } else { depth });
        DepthSamples::Metres(holed.collect())
    };
    let bad = |sensor, ms| of_samples(sensor, ms, half(0.9), small_camera(), mount);
    let mut states = |observation: &limpid::sensor::Observation| {
        rig.see(observation);
        let out = rig.publish(None);
        (out.map.state, out.map.sensors)
    };
    use State::{Degraded, Ok, Stale};
    assert_eq!(states(&good(0, 0)), (Stale, vec![Ok, Stale]));
    assert_eq!(states(&good(1, 10)), (Ok, vec![Ok, Ok]));
    assert_eq!(states(&bad(1, 20)), (Degraded, vec![Ok, Degraded]));
    assert_eq!(states(&good(0, 30)), (Degraded, vec![Ok, Degraded]), "as its own last frame has it");
    assert_eq!(states(&good(0, 600)), (Stale, vec![Ok, Stale]), "0.58 s without data are worse");
    assert_eq!(states(&good(1, 610)), (Ok, vec![Ok, Ok]));
}

#[test]
fn truth_single_cells_grow_old_by_their_own_age() {
    if skipped() {
        return;
    }
    let config = Config { cell_timeout_s: 0.3, ..config() };
    let mut rig = Rig::open(&config, &camera_and_lidar(&config));
    let scene = room(&[Block::new([1.513, -0.4, 0.0], [1.6, 0.4, 0.9])]);
    for index in 0..FRAMES {
        rig.see(&frame(0, index * 33, &scene, small_camera(), mount(0.0, 0.2)));
    }
    rig.see(&sweep(1, 297, &dim_wall(-1.53, -0.5..0.5, 0.7)));
    // The camera turns away; the lidar sees the half of what it saw.
    let places = [[1.12, 0.02], [1.52, 0.02], [-1.52, 0.32], [-1.02, 0.22], [-1.52, -0.32], [-1.02, -0.22]];
    let mut rows = |ms: u64| {
        rig.see(&frame(0, ms, &scene, small_camera(), mount(0.5 * PI, 0.2)));
        rig.see(&sweep(1, ms, &dim_wall(-1.53, 0.0..0.5, 0.7)));
        let out = rig.publish(None);
        (out.map.state, places.map(|place| out.said(place).0))
    };
    assert_eq!(rows(400), (State::Ok, [9, 6, 7, 8, 7, 8]));
    assert_eq!(rows(590), (State::Ok, [9, 6, 7, 8, 7, 8]), "0.29 s old");
    assert_eq!(rows(620), (State::Ok, [11, 6, 7, 8, 11, 11]), "lethal cells stay, and those that are seen");
}
