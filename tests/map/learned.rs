//! Fusion by map reliability, from depth to the map: what holds for evidence holds for what a network makes of it.

use limpid::Config;
use limpid::config::{Fusion, Method};
use limpid::mapper::{Mapper, SensorInfo};
use limpid::sensor::{CameraInfo, DepthSamples};

use super::evidence::{
    FACE, ahead, cells_after_turning, cells_of_a_walk, lethal_cells, person, room, scenes, with_confidence,
};
use crate::one_map::rig;
use crate::support::gpu::skipped;
use crate::support::run::{cell, lethal, run, still};
use crate::support::scene::small_camera;

fn config() -> Config {
    Config { fusion: Fusion::Learned, method: Method::Naive, ..Config::default() }
}

#[test]
fn obstacles_are_marked_within_three_frames_and_given_up_within_ten() {
    if skipped() {
        return;
    }
    let out = run(&config(), &scenes(&[(room(&[person(0.0)]), 30), (room(&[]), 12)], 3));
    let states: Vec<bool> = out.iter().map(|out| lethal(out, FACE[0], FACE[1])).collect();
    let first = states.iter().position(|state| *state);
    assert!(first.is_some_and(|frame| (1..=2).contains(&frame)), "{states:?}");
    assert!(states[2..30].iter().all(|state| *state), "{states:?}");
    assert!(states[40..].iter().all(|state| !*state), "{states:?}");
    assert_eq!(out[41].costmap[cell(&out[41], FACE[0], FACE[1])], 0, "free");
}

#[test]
fn a_person_who_walks_through_leaves_nothing_after_a_second_at_10_hz() {
    if skipped() {
        return;
    }
    let (seen, left, lethal, quiet) = cells_of_a_walk(&config());
    assert!(seen > 3, "the person is seen while there: {seen} cells");
    assert_eq!(left, 0, "a second after");
    assert_eq!(lethal, quiet, "as if nobody had come");
}

#[test]
fn a_chair_that_is_moved_after_a_long_standstill_is_gone_as_soon_as_after_a_short_one() {
    if skipped() {
        return;
    }
    let gone = |stood: u64| {
        let out = run(&config(), &scenes(&[(room(&[person(0.0)]), stood), (room(&[person(0.6)]), 12)], 3));
        let after = &out[stood as usize..];
        let left = after.iter().position(|out| !lethal(out, FACE[0], FACE[1]));
        let came = after.iter().position(|out| lethal(out, 1.53, 0.62));
        (left, came)
    };
    // What is kept of looks has forgotten its beginning after 60 of them (0.9^60 is 0.002); an hour is like 90.
    let (short, long) = (gone(60), gone(90));
    assert_eq!(short, long);
    assert!(short.0.is_some_and(|frames| frames <= 9), "gone within a second at 10 Hz: {short:?}");
    assert!(short.1.is_some_and(|frames| frames <= 9), "and found where it went: {short:?}");
}

#[test]
fn doubtful_and_missing_reliability_and_frames_that_see_nothing_change_nothing() {
    if skipped() {
        return;
    }
    for bad in [f32::NAN, 0.3] {
        let out = run(&config(), &with_confidence(still(&room(&[person(0.0)]), ahead(), 6), |_, _| bad));
        assert!(out.iter().all(|out| out.costmap.iter().all(|cost| *cost == 255)), "R = {bad}");
        let frames = scenes(&[(room(&[person(0.0)]), 10), (room(&[]), 20)], 3);
        let out = run(&config(), &with_confidence(frames, |index, _| if index < 30 { 1.0 } else { bad }));
        assert_eq!(out[29].costmap, out[9].costmap, "R = {bad}");
    }
    let sure = run(&config(), &with_confidence(still(&room(&[person(0.0)]), ahead(), 6), |_, _| 1.0));
    let plain = run(&config(), &still(&room(&[person(0.0)]), ahead(), 6));
    assert_eq!(sure[5].costmap, plain[5].costmap, "R = 1 is depth alone");
    let mut frames = scenes(&[(room(&[person(0.0)]), 5), (room(&[]), 3)], 3);
    for frame in &mut frames[5..] {
        let pixels = frame.depth.samples.len();
        frame.depth.samples = DepthSamples::Metres(vec![0.0; pixels]);
    }
    let out = run(&config(), &frames);
    assert_eq!(out[7].costmap, out[4].costmap);
}

#[test]
fn fast_turns_keep_walls_where_they_are_and_leave_none_elsewhere() {
    if skipped() {
        return;
    }
    let (inside, on) = cells_after_turning(&config());
    assert_eq!(inside, 0, "phantoms");
    assert!(on > 290, "{on} cells of four walls of 80");
}

#[test]
fn a_bias_moves_between_missed_and_false_obstacles() {
    if skipped() {
        return;
    }
    let of = |learned_bias| {
        let frames = still(&room(&[person(0.0)]), ahead(), 6);
        lethal_cells(&run(&Config { learned_bias, ..config() }, &frames)[5])
    };
    let cells = [-100.0, 0.0, 100.0].map(of);
    assert!(cells[0] == 0 && cells[0] < cells[1] && cells[1] <= cells[2], "{cells:?}");
}

#[test]
fn cells_of_other_sides_and_cameras_of_another_fusion_are_refused() {
    if skipped() {
        return;
    }
    let coarse = Config { resolution_m: 0.1, ..config() };
    let frame = room(&[]).frame(0, small_camera(), ahead());
    let info = CameraInfo::of_frames([&frame]).unwrap();
    let open = |config: &Config| {
        let sensors = [SensorInfo::camera(config, info)];
        Mapper::open(config, &sensors, &limpid::Options::default()).map(|_| ()).map_err(|e| e.to_string())
    };
    let error = open(&coarse).unwrap_err();
    assert!(
        error.contains("fusion") && error.contains("not of 0.1 m") && error.contains("evidence"),
        "{error}"
    );
    assert_eq!(open(&Config { fusion: Fusion::Auto, ..coarse }), Ok(()));
    let missing = Config { learned_weights: "no/such.safetensors".into(), ..config() };
    assert!(open(&missing).unwrap_err().contains("no/such.safetensors"));
    let of_drm = Config { learned_weights: "weights/drm-net.safetensors".into(), ..config() };
    assert!(open(&of_drm).unwrap_err().contains("`format`"));
    let mut cameras = rig::two_cameras(&config());
    cameras[1].config.fusion = Fusion::Evidence;
    let both = Mapper::open(&config(), &cameras, &limpid::Options::default());
    assert!(both.err().unwrap().to_string().contains("`learned`"));
}
