//! Rows 2 to 4 and 6 to 11 of the rule: a scene in which each has its cell, and scenes beside it in which it has none.

use limpid::Config;
use limpid::sensor::DepthSamples;

use super::rig::{
    FRAME_MS, FRAMES, Published, Return, Rig, camera_and_lidar, config, dim_wall, frame, mount, of_samples,
    room, sweep,
};
use crate::support::gpu::skipped;
use crate::support::scene::{Block, Scene, small_camera};

const CAMERA: usize = 0;
const LIDAR: usize = 1;

/// A bright return.
const SOLID: [f64; 2] = [2.02, 0.62];
/// A dim one.
const PASSABLE: [f64; 2] = [2.02, 0.32];
/// A dim one at the lidar's own height, and none below it.
const TRANSPARENT: [f64; 2] = [2.02, -0.12];
/// A dim one from a post that the camera sees.
const POST: [f64; 2] = [1.52, -0.42];
/// A post that no beam meets.
const OTHER_POST: [f64; 2] = [2.02, 0.92];
/// Where beams go to the wall, in the camera's view and behind it.
const CROSSED: [f64; 2] = [1.02, -0.42];
const CROSSED_BEHIND: [f64; 2] = [-1.02, 0.02];
/// Where the camera alone looks.
const LOOKED_AT: [f64; 2] = [1.22, -0.22];
const NEVER_SEEN: [f64; 2] = [0.02, 2.02];

fn scene() -> Scene {
    room(&[
        Block::new([1.513, -0.449, 0.0], [1.6, -0.401, 0.9]),
        Block::new([2.013, 0.87, 0.0], [2.1, 0.98, 0.9]),
    ])
}

fn returns() -> Vec<Return> {
    let mut returns = vec![
        ([SOLID[0], SOLID[1], 0.8], 200.0),
        ([PASSABLE[0], PASSABLE[1], 0.8], 40.0),
        ([TRANSPARENT[0], TRANSPARENT[1], 0.6], 60.0),
        ([POST[0], POST[1], 0.8], 40.0),
    ];
    returns.extend(dim_wall(3.53, -2.3..-1.2, 0.7));
    returns.extend(dim_wall(-3.53, -0.5..0.5, 0.7));
    returns
}

/// Ten frames of the scene, then a scan at the stamp of the last.
fn rig(config: &Config, scene: &Scene, returns: &[Return]) -> Rig {
    let mut rig = Rig::open(config, &camera_and_lidar(config));
    for index in 0..FRAMES {
        rig.see(&frame(CAMERA, index * FRAME_MS, scene, small_camera(), mount(0.0, 0.2)));
    }
    rig.see(&sweep(LIDAR, (FRAMES - 1) * FRAME_MS, returns));
    rig
}

fn seen(config: &Config, returns: &[Return]) -> Published {
    rig(config, &scene(), returns).publish(None)
}

#[test]
fn truth_every_row_has_its_cell_with_cost_sensor_and_age() {
    if skipped() {
        return;
    }
    let mut rig = rig(&config(), &scene(), &returns());
    let now = rig.publish(None);
    let later = rig.publish(Some(297 + 400));
    for (place, row, cost, sensor) in [
        (SOLID, 2, 254, Some(LIDAR)),
        (TRANSPARENT, 3, 254, Some(LIDAR)),
        (POST, 4, 254, Some(CAMERA)),
        (OTHER_POST, 6, 254, Some(CAMERA)),
        (PASSABLE, 7, 50, Some(LIDAR)),
        (CROSSED, 8, 0, Some(LIDAR)),
        (CROSSED_BEHIND, 8, 0, Some(LIDAR)),
        (LOOKED_AT, 9, 0, Some(CAMERA)),
        (NEVER_SEEN, 10, 255, None),
    ] {
        assert_eq!(now.said(place), (row, cost), "{place:?}");
        assert_eq!(now.verdict(place).sensor(), sensor, "{place:?}");
        assert!(now.verdict(place).age_s().abs() < 1e-9, "{place:?}: {}", now.verdict(place).age_s());
        // 0.4 s later, within the timeout, all is as it was, and older by that.
        assert_eq!(later.said(place), (row, cost), "{place:?}");
        let age_s = if sensor.is_some() { 0.4 } else { 0.0 };
        assert!((later.verdict(place).age_s() - age_s).abs() < 1e-9, "{place:?}");
    }
    assert!([1, 5, 11].iter().all(|&row| now.map.verdicts.iter().all(|verdict| verdict.row() != row)));
}

#[test]
fn truth_row_11_takes_free_and_passable_cells_of_stale_sensors_and_leaves_lethal_ones() {
    if skipped() {
        return;
    }
    let mut rig = rig(&config(), &scene(), &returns());
    let fresh = rig.publish(None);
    let stale = rig.publish(Some(297 + 510));
    for place in [PASSABLE, CROSSED, CROSSED_BEHIND, LOOKED_AT] {
        assert_ne!(fresh.said(place).0, 11, "the control");
        assert_eq!(stale.said(place), (11, 255), "{place:?}");
        assert_eq!(stale.verdict(place).sensor(), fresh.verdict(place).sensor(), "{place:?}");
        assert!((stale.verdict(place).age_s() - 0.5).abs() < 1e-9, "{place:?}");
    }
    for place in [SOLID, TRANSPARENT, POST, OTHER_POST, NEVER_SEEN] {
        assert_eq!(stale.said(place), fresh.said(place), "{place:?}");
    }
}

#[test]
fn truth_a_camera_that_goes_on_stands_for_a_lidar_that_ended() {
    if skipped() {
        return;
    }
    let mut rig = rig(&config(), &scene(), &returns());
    let before = rig.publish(None);
    for index in 0..20 {
        rig.see(&frame(CAMERA, 330 + index * FRAME_MS, &scene(), small_camera(), mount(0.0, 0.2)));
    }
    let after = rig.publish(None);
    assert_eq!((before.verdict(CROSSED).sensor(), before.said(CROSSED)), (Some(LIDAR), (8, 0)));
    assert_eq!((after.verdict(CROSSED).sensor(), after.said(CROSSED)), (Some(CAMERA), (8, 0)));
    assert_eq!(after.said(CROSSED_BEHIND), (11, 255), "nobody else looks there");
    assert_eq!([after.said(SOLID), after.said(TRANSPARENT)], [(2, 254), (3, 254)], "no camera clears them");
}

#[test]
fn truth_row_4_asks_passable_over_camera() {
    if skipped() {
        return;
    }
    for (passable_over_camera, said, sensor) in [(false, (4, 254), CAMERA), (true, (4, 50), LIDAR)] {
        let config = Config { passable_over_camera, ..config() };
        let out = seen(&config, &returns());
        assert_eq!((out.said(POST), out.verdict(POST).sensor()), (said, Some(sensor)));
        // Where the lidar says nothing, the switch says nothing either.
        assert_eq!(out.said(OTHER_POST), (6, 254));
        // Where the camera sees through, it is no matter of row 4.
        assert_eq!(out.said(PASSABLE), (7, 50));
    }
}

#[test]
fn the_rows_of_lidars_need_their_returns() {
    if skipped() {
        return;
    }
    // The bright return lies too low for any layer, the dim one is brighter, and what was glass has a return below too.
    let mut others = returns();
    others[0].0[2] = 0.05;
    others[1].1 = 140.0;
    others.push(([TRANSPARENT[0], TRANSPARENT[1], 0.45], 60.0));
    let out = seen(&config(), &others);
    assert_eq!(out.said(SOLID), (9, 0), "row 2 has none: the camera sees through");
    assert_eq!(out.said(PASSABLE), (2, 254), "row 7 has none");
    assert_eq!(out.said(TRANSPARENT), (7, 50), "row 3 has none");
    // A cell needs as many returns as configured.
    let out = seen(&Config { min_returns: 2, ..config() }, &returns());
    assert_eq!([SOLID, PASSABLE, TRANSPARENT].map(|place| out.said(place)), [(9, 0); 3]);
    assert_eq!(out.said(POST), (6, 254), "row 4 has none");
}

#[test]
fn beams_and_rays_free_nothing_behind_what_they_end_at() {
    if skipped() {
        return;
    }
    let wall = room(&[Block::new([1.513, -3.0, 0.0], [1.6, 3.0, 2.5])]);
    let out = rig(&config(), &wall, &dim_wall(1.53, 0.3..0.6, 0.7)).publish(None);
    assert_eq!([out.said([1.02, -0.12]), out.said([1.02, 0.32])], [(9, 0), (8, 0)]);
    assert_eq!([out.said([2.02, -0.12]), out.said([2.02, 0.62])], [(10, 255); 2]);
    assert_eq!([out.said([1.52, -0.12]), out.said([1.52, 0.42])], [(6, 254), (4, 254)]);
}

#[test]
fn a_camera_alone_needs_evidence_for_rows_6_and_9() {
    if skipped() {
        return;
    }
    let config = config();
    let mut rig = Rig::open(&config, &camera_and_lidar(&config));
    let holes = DepthSamples::Metres(vec![0.0; 160 * 120]);
    rig.see(&of_samples(CAMERA, 0, holes, small_camera(), mount(0.0, 0.2)));
    let out = rig.publish(None);
    assert!(out.map.verdicts.iter().all(|verdict| verdict.row() == 10), "holes say nothing");
    let occupied = (0..FRAMES).position(|index| {
        rig.see(&frame(CAMERA, 33 + index * FRAME_MS, &scene(), small_camera(), mount(0.0, 0.2)));
        let said = rig.publish(None).said(OTHER_POST);
        assert!(
            said == (6, 254) || said == (10, 255),
            "a thing that is not confirmed yet is unknown: {said:?}"
        );
        said == (6, 254)
    });
    assert_eq!(occupied, Some(7), "1 - 0.85^8 is the first above 0.7");
}
