//! Fusion by evidence, from depth to the map: how soon, how long, and what bad frames do.

use limpid::Config;
use limpid::config::{Fusion, Method};
use limpid::map::Occupancy;
use limpid::mapper::{Mapper, SensorInfo};
use limpid::sensor::{CameraInfo, FramePose, Observation, RgbdFrame};

use crate::one_map::rig;
use crate::support::gpu::skipped;
use crate::support::run::{FrameOutput, cell, evidence, lethal, run, still};
use crate::support::scene::{Block, Scene, pose, small_camera};

fn config() -> Config {
    Config { fusion: Fusion::Evidence, method: Method::Naive, ..Config::default() }
}

/// A wall across the room, and its face.
fn far_wall() -> Block {
    Block::new([3.52, -4.0, 0.0], [3.7, 4.0, 1.5])
}

/// Where people stand and chairs are: 1.5 m ahead, a little to a side.
pub(super) fn person(y: f64) -> Block {
    Block::new([1.52, y - 0.2, 0.0], [1.77, y + 0.2, 1.7])
}

pub(super) const FACE: [f64; 2] = [1.53, 0.02];

pub(super) fn ahead() -> FramePose {
    pose(0.01, 0.02, 0.0, 0.6, 0.2)
}

pub(super) fn room(blocks: &[Block]) -> Scene {
    Scene::of(&[&[far_wall()], blocks].concat())
}

/// Frames of one scene after another, each for so many frames, `step` numbers apart (3: 10 Hz).
pub(super) fn scenes(parts: &[(Scene, u64)], step: u64) -> Vec<RgbdFrame> {
    let all = parts.iter().flat_map(|(scene, count)| (0..*count).map(move |_| scene));
    all.zip(0..).map(|(scene, number)| scene.frame(number * step, small_camera(), ahead())).collect()
}

pub(super) fn with_confidence(mut frames: Vec<RgbdFrame>, of: impl Fn(u64, usize) -> f32) -> Vec<RgbdFrame> {
    for frame in &mut frames {
        let pixels = frame.depth.samples.len();
        frame.confidence = Some((0..pixels).map(|pixel| of(frame.index, pixel)).collect());
    }
    frames
}

pub(super) fn lethal_cells(out: &FrameOutput) -> usize {
    out.costmap.iter().filter(|cost| **cost == 254).count()
}

#[test]
fn marks_at_the_second_frame_and_frees_after_six() {
    if skipped() {
        return;
    }
    let out = run(&config(), &scenes(&[(room(&[person(0.0)]), 30), (room(&[]), 8)], 3));
    let states: Vec<bool> = out.iter().map(|out| lethal(out, FACE[0], FACE[1])).collect();
    let want = |frame: usize| (1..35).contains(&frame);
    assert_eq!(states, (0..38).map(want).collect::<Vec<_>>());
    assert_eq!(out[37].costmap[cell(&out[37], FACE[0], FACE[1])], 0, "free");
    assert_eq!(evidence(&out[5], FACE[0], FACE[1]), 1.0);
}

/// A person who walks across at 1.2 m/s, seen at 30 Hz and then for a second at 10 Hz: the least number of lethal cells on the path
/// while there, those a second after, all lethal cells then, and all of a room in which nobody came.
pub(super) fn cells_of_a_walk(config: &Config) -> (usize, usize, usize, usize) {
    // A cell that was clear needs five looks, so that what covers it for fewer is not marked.
    let walk: Vec<(Scene, u64)> = (0..24).map(|k| (room(&[person(-0.5 + 0.04 * f64::from(k))]), 1)).collect();
    let out = run(config, &scenes(&[walk.as_slice(), &[(room(&[]), 10)]].concat(), 3));
    let path = |out: &FrameOutput| {
        let places =
            (-12..=12).flat_map(|y| (30..36).map(move |x| (f64::from(x) * 0.05 + 0.01, f64::from(y) * 0.05)));
        places.filter(|(x, y)| lethal(out, *x, *y)).count()
    };
    let quiet = run(config, &scenes(&[(room(&[]), 34)], 3));
    let seen = out[10..20].iter().map(path).min().unwrap_or(0);
    (seen, path(&out[33]), lethal_cells(&out[33]), lethal_cells(&quiet[33]))
}

#[test]
fn a_person_who_walks_through_leaves_nothing_after_a_second_at_10_hz() {
    if skipped() {
        return;
    }
    let (seen, left, lethal, quiet) = cells_of_a_walk(&config());
    assert!(seen > 3, "the person is seen while there");
    assert_eq!(left, 0, "a second after");
    assert_eq!(lethal, quiet, "as if nobody had come");
}

#[test]
fn a_chair_that_is_moved_after_a_long_standstill_is_gone_as_soon_as_after_a_short_one() {
    if skipped() {
        return;
    }
    // Evidence is at its most after 12 frames, and the same in every frame from there on: an hour is like 60 frames.
    let gone = |stood: u64| {
        let out = run(&config(), &scenes(&[(room(&[person(0.0)]), stood), (room(&[person(0.6)]), 12)], 3));
        let after = &out[stood as usize..];
        let left = after.iter().position(|out| !lethal(out, FACE[0], FACE[1]));
        let came = after.iter().position(|out| lethal(out, 1.53, 0.62));
        (left, came)
    };
    let (short, long) = (gone(15), gone(60));
    assert_eq!(short, long);
    assert_eq!(short.0, Some(5), "after six clear frames");
    assert!(short.1.is_some_and(|frames| frames <= 5), "and it is found where it went: {short:?}");
}

#[test]
fn reliability_of_0_marks_and_clears_nothing_and_so_does_nan() {
    if skipped() {
        return;
    }
    for bad in [0.0, f32::NAN, -1.0, 0.3] {
        let out = run(&config(), &with_confidence(still(&room(&[person(0.0)]), ahead(), 6), |_, _| bad));
        assert!(out.iter().all(|out| out.costmap.iter().all(|cost| *cost == 255)), "R = {bad}");
        // Nor does it change what is known.
        let frames = scenes(&[(room(&[person(0.0)]), 10), (room(&[]), 20)], 3);
        let out = run(&config(), &with_confidence(frames, |index, _| if index < 30 { 1.0 } else { bad }));
        assert_eq!(out[29].costmap, out[9].costmap, "R = {bad}");
    }
    let sure = run(&config(), &with_confidence(still(&room(&[person(0.0)]), ahead(), 6), |_, _| 1.0));
    let plain = run(&config(), &still(&room(&[person(0.0)]), ahead(), 6));
    assert_eq!(sure[5].costmap, plain[5].costmap, "R = 1 is depth alone");
    assert!(lethal(&sure[5], FACE[0], FACE[1]));
}

#[test]
fn frames_that_see_nothing_change_nothing() {
    if skipped() {
        return;
    }
    let mut frames = scenes(&[(room(&[person(0.0)]), 5), (room(&[]), 3)], 3);
    for frame in &mut frames[5..] {
        let pixels = frame.depth.samples.len();
        frame.depth.samples = limpid::sensor::DepthSamples::Metres(vec![0.0; pixels]);
    }
    let out = run(&config(), &frames);
    assert_eq!(out[7].costmap, out[4].costmap);
    let nothing = run(&config(), &frames[5..]);
    assert!(nothing.iter().all(|out| out.costmap.iter().all(|cost| *cost == 255)));
}

/// Lethal cells before the walls of a closed room and of the walls themselves, 80 cells each, after the camera turned about at 180
/// degrees a second for 4 s.
pub(super) fn cells_after_turning(config: &Config) -> (usize, usize) {
    // 14 mm of the walls are the thickness of nothing.
    let walls = [
        Block::new([2.02, -2.6, 0.0], [2.2, 2.6, 1.5]),
        Block::new([-2.2, -2.6, 0.0], [-2.02, 2.6, 1.5]),
        Block::new([-2.6, 2.02, 0.0], [2.6, 2.2, 1.5]),
        Block::new([-2.6, -2.2, 0.0], [2.6, -2.02, 1.5]),
    ];
    let scene = Scene::of(&walls);
    let turn = |index: u64| pose(0.01, 0.02, 0.105 * index as f64, 0.6, 0.2);
    let frames: Vec<_> = (0..120).map(|index| scene.frame(index, small_camera(), turn(index))).collect();
    let out = run(config, &frames);
    let last = &out[119];
    let places = (-45..45).flat_map(|y| (-45..45).map(move |x| (x, y)));
    let (mut inside, mut on) = (0, 0);
    for (x, y) in places {
        let at = [x, y].map(|k| f64::from(k) * 0.05 + 0.025);
        let far = at[0].abs().max(at[1].abs());
        inside += usize::from(far < 1.95 && lethal(last, at[0], at[1]));
        on += usize::from((2.0..2.05).contains(&far) && lethal(last, at[0], at[1]));
    }
    (inside, on)
}

#[test]
fn fast_turns_keep_walls_where_they_are_and_leave_none_elsewhere() {
    if skipped() {
        return;
    }
    let (inside, on) = cells_after_turning(&config());
    assert_eq!(inside, 0, "phantoms");
    // Four walls of 80 cells.
    assert!(on > 290, "{on} cells of the walls");
}

#[test]
fn what_is_seen_once_is_neither_an_obstacle_nor_free() {
    if skipped() {
        return;
    }
    let out = run(&config(), &still(&room(&[person(0.0)]), ahead(), 1));
    assert_eq!(lethal_cells(&out[0]), 0);
    assert_eq!(out[0].costmap[cell(&out[0], FACE[0], FACE[1])], 255);
    assert_eq!(out[0].costmap[cell(&out[0], 1.0, 0.0)], 0, "looks through free at once");
}

#[test]
fn weak_depth_marks_only_where_it_stands_beside_what_is_sure() {
    if skipped() {
        return;
    }
    let frames = || still(&room(&[person(0.0)]), ahead(), 40);
    let weak = run(&config(), &with_confidence(frames(), |_, _| 0.6));
    assert_eq!(lethal_cells(&weak[39]), 0, "R = 0.6 alone never marks");
    let half =
        run(&config(), &with_confidence(frames(), |_, pixel| if pixel % 160 < 80 { 1.0 } else { 0.6 }));
    let edge = [0.0, -0.05, -0.1].map(|y| lethal(&half[39], 1.53, y + 0.02));
    assert!(edge[0] || edge[1], "grown by a cell from the sure half: {edge:?}");
}

#[test]
fn costs_and_reasons_agree_and_why_tells_the_evidence() {
    if skipped() {
        return;
    }
    let frame = room(&[person(0.0)]).frame(0, small_camera(), ahead());
    let info = CameraInfo::of_frames([&frame]).unwrap();
    let sensors = [SensorInfo::camera(&config(), info)];
    let options = limpid::Options { verdicts: true, ..Default::default() };
    let mut mapper = Mapper::open(&config(), &sensors, &options).unwrap();
    let mut last = None;
    for frame in still(&room(&[person(0.0)]), ahead(), 5) {
        last = Some(mapper.step(&Observation::of_frame(0, "map", frame)).unwrap());
    }
    let why = mapper.why(last.as_ref().unwrap(), FACE[0], FACE[1]).unwrap().unwrap();
    let camera = why.camera.unwrap();
    // 1, 1.95, 2.85, 3.71, 4.52.
    let [support, opposed] = camera.evidence.unwrap();
    assert!((support - 4.524).abs() < 0.01 && opposed == 0.0, "{support}, {opposed}");
    assert_eq!((camera.state, camera.occupancy, why.cost), (Occupancy::Occupied, 1.0, 254));
    let text = why.text(&limpid::map::rule::RuleSettings::default(), &["front".into()]);
    assert!(text.contains("occupied (4.52 for, 0.00 against), hit 0.1"), "{text}");
    let map = last.unwrap().map.unwrap();
    assert!(
        map.verdicts
            .iter()
            .zip(&map.costmap)
            .all(|(verdict, cost)| (*cost == 254) == (verdict.cost() == 254))
    );
}

#[test]
fn cameras_of_one_map_share_the_fusion() {
    if skipped() {
        return;
    }
    let mut cameras = rig::two_cameras(&config());
    let open = |cameras: &[SensorInfo]| Mapper::open(&config(), cameras, &limpid::Options::default());
    assert!(open(&cameras).is_ok());
    cameras[1].config.fusion = Fusion::Gate;
    let error = open(&cameras).err().unwrap().to_string();
    assert!(error.contains("fusion") && error.contains("`front` and `rear` differ"), "{error}");
    cameras[0].config.fusion = Fusion::Weight;
    assert!(open(&cameras).is_ok(), "weight and gate both keep p");
    // Without a word of it: what another camera states.
    cameras[0].config.fusion = Fusion::Auto;
    assert!(open(&cameras).is_ok());
    cameras[1].config.fusion = Fusion::Evidence;
    assert!(open(&cameras).is_ok());
}
