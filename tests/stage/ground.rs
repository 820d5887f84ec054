//! The ground: its samples, the planes that are drawn, and what is kept.

use bytemuck::{Zeroable, cast_slice};
use glam::{DQuat, DVec2, DVec3};
use limpid::Config;
use limpid::base::Rigid;
use limpid::gpu::Invocations;
use limpid::sensor::{CameraModel, FramePose, SensorPose};
use limpid::stage::camera::back_project::rays;
use limpid::stage::ground::{
    DRAW, GroundMoment, GroundParams, HYPOTHESES, MOST_SAMPLES, PIXELS, RETURNS, SAMPLE_ROW, SCORE, SETTLE,
    Sampled, params,
};
use limpid::stage::lidar::intensity_layers::POINT_ROW;

use crate::reference::ground::{self as twin, Plane, Sample};
use crate::support::camera_job::tiny_camera;
use crate::support::compare::{Tolerance, assert_close};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;
use crate::support::scene::{Block, Scene, pose};

const ROWS: u32 = MOST_SAMPLES / SAMPLE_ROW;
const PLACE: Tolerance = Tolerance { absolute: 2e-5, reason: "f32 at ten metres, turned" };
const FIT: Tolerance = Tolerance {
    absolute: 2e-3,
    reason: "f32 sums, and samples at the border of the tolerance may fall on either side",
};
/// Samples at the border of the tolerance.
const BORDER: usize = 3;

/// What the passes keep of a sensor, as words.
type Kept = [f32; 8];

/// What `ground/settle` tells.
struct Told {
    heights: [f32; 4],
    source: f32,
    sensor_height_m: f32,
    areas_m2: [f32; 2],
    kept: [f32; 4],
    shown_as: f32,
    share: f32,
    plane: [f32; 4],
}

struct Message {
    params: GroundParams,
    samples: Vec<[f32; 4]>,
    kept: Vec<Kept>,
}

impl Message {
    fn draw(&self) -> (Vec<[f32; 4]>, Vec<u32>) {
        let out = Fragment::new()
            .params("ground_params", &self.params)
            .float_texture("ground_samples", SAMPLE_ROW, ROWS, &self.samples)
            .input("ground", &self.kept)
            .output("ground_planes", 4 * HYPOTHESES as usize)
            .output("ground_scores", HYPOTHESES as usize)
            .run(DRAW, Invocations::line(HYPOTHESES));
        let planes: Vec<[f32; 4]> = cast_slice(&out.floats("ground_planes")).to_vec();
        assert!(out.words("ground_scores").iter().all(|&score| score == 0));
        let out = Fragment::new()
            .params("ground_params", &self.params)
            .float_texture("ground_samples", SAMPLE_ROW, ROWS, &self.samples)
            .input("ground_planes", &planes)
            .changed("ground_scores", &vec![0_u32; HYPOTHESES as usize])
            .run(SCORE, Invocations::area(HYPOTHESES / 8, 16));
        (planes, out.words("ground_scores").to_vec())
    }

    fn settle(&self, planes: &[[f32; 4]], scores: &[u32]) -> (Told, Vec<Kept>) {
        let out = Fragment::new()
            .params("ground_params", &self.params)
            .float_texture("ground_samples", SAMPLE_ROW, ROWS, &self.samples)
            .input("ground_planes", planes)
            .input("ground_scores", scores)
            .changed("ground", &self.kept)
            .output("ground_now", 20)
            .run(SETTLE, Invocations::line(1));
        let now: Vec<[f32; 4]> = cast_slice(&out.floats("ground_now")).to_vec();
        let told = Told {
            heights: now[0],
            source: now[1][0],
            sensor_height_m: now[1][1],
            areas_m2: [now[1][2], now[1][3]],
            kept: now[2],
            shown_as: now[3][0],
            share: now[3][1],
            plane: now[4],
        };
        (told, cast_slice(&out.floats("ground")).to_vec())
    }

    fn run(&self) -> (Told, Vec<Kept>) {
        let (planes, scores) = self.draw();
        self.settle(&planes, &scores)
    }

    /// As the twin takes them.
    fn twin_samples(&self) -> Vec<Sample> {
        let taken = self.samples.iter().filter(|sample| sample[3] > 0.0);
        taken.map(|s| (DVec3::new(s[0].into(), s[1].into(), s[2].into()), s[3].into())).collect()
    }
}

fn moment<'a>(config: &'a Config, sampled: Sampled, pose: SensorPose) -> GroundMoment<'a> {
    GroundMoment {
        config,
        sampled,
        pose,
        local_origin_m: DVec3::ZERO,
        zero_m: DVec3::new(-3.0, -2.0, config.ground_z_m),
        tick: 7,
        sensor: 0,
        sensors: 1,
    }
}

fn sampled_pixels(
    camera: &CameraModel,
    params: &GroundParams,
    depth_m: &[f32],
    reliability: &[f32],
) -> Vec<[f32; 4]> {
    let out = Fragment::new()
        .params("ground_params", params)
        .input("depth_m", depth_m)
        .input("reliability", reliability)
        .input("rays", &rays(camera))
        .texture_output("ground_samples", SAMPLE_ROW, ROWS)
        .constants(&[("distorted", false)])
        .run(PIXELS, Invocations::line(MOST_SAMPLES));
    cast_slice(&out.floats("ground_samples")).to_vec()
}

/// What a camera sees of a scene from where it truly is, placed at `told`.
fn message(config: &Config, scene: &Scene, truly: FramePose, told: FramePose) -> Message {
    let camera = tiny_camera();
    let depth_m = scene.depth(&camera, truly.map_from_base.then(truly.base_from_camera));
    let params = params(&moment(config, Sampled::Pixels(camera), told.into()));
    let samples = sampled_pixels(&camera, &params, &depth_m, &vec![1.0; depth_m.len()]);
    Message { params, samples, kept: vec![Kept::zeroed()] }
}

/// z = x a + y b + c of n . p = d.
fn slopes(plane: [f32; 4]) -> Plane {
    let [x, y, z, d] = plane.map(f64::from);
    DVec3::new(-x, -y, d) / z
}

fn level_camera(height_m: f64) -> FramePose {
    pose(0.1, 0.2, 0.4, height_m, 0.35)
}

fn scene() -> Scene {
    Scene::of(&[Block::new([2.6, -1.0, 0.0], [3.0, 0.4, 0.9]), Block::new([1.2, 0.9, 0.0], [1.5, 1.2, 0.4])])
}

#[test]
fn truth_a_floor_that_the_mount_tilts_is_found() {
    if skipped() {
        return;
    }
    let config = Config { ground_z_m: 0.3, ..Config::default() };
    let truly = level_camera(0.6);
    for (tilt_deg, lift_m) in [(0.0, 0.0), (4.0, 0.1), (-6.0, -0.2)] {
        let turn = DQuat::from_rotation_y(f64::to_radians(tilt_deg));
        let base_from_camera = Rigid {
            rotation: turn * truly.base_from_camera.rotation,
            translation_m: truly.base_from_camera.translation_m + DVec3::Z * lift_m,
        };
        let message = message(&config, &scene(), truly, FramePose { base_from_camera, ..truly });
        let (told, kept) = message.run();
        assert_eq!((told.shown_as, told.source), (2.0, 1.0), "tilt {tilt_deg}");
        // Up is turned with the camera.
        let up = DQuat::from_rotation_z(0.4) * turn * DVec3::Z;
        let found = DVec3::new(told.plane[0].into(), told.plane[1].into(), told.plane[2].into());
        assert!(found.angle_between(up).to_degrees() < 0.15, "{found} for {up}");
        assert!((f64::from(-told.plane[3]) - 0.6).abs() < 2e-3, "{:?}", told.plane);
        assert_close("sensor height", &[told.sensor_height_m], &[0.6_f32], FIT);
        assert_eq!(told.kept, told.plane, "the first is taken as it is");
        // A place on the floor under the camera has height 0 in the window.
        let under = DVec3::new(0.1, 0.2, 0.6 + lift_m) - up * 0.6 - DVec3::new(-3.0, -2.0, 0.3);
        let [x, y, z, w] = told.heights.map(f64::from);
        assert!((DVec3::new(x, y, z).dot(under) + w).abs() < 3e-3);
        assert_eq!((kept[0][4].to_bits(), kept[0][5].to_bits()), (7, 1), "tick and count");
    }
}

#[test]
fn a_floor_where_it_is_stated_leaves_heights_as_they_are_stated() {
    if skipped() {
        return;
    }
    let config = Config::default();
    let truly = level_camera(0.6);
    let (told, _) = message(&config, &scene(), truly, truly).run();
    assert_eq!((told.shown_as, told.source), (2.0, 1.0));
    assert_eq!(told.heights, [0.0, 0.0, 1.0, 0.0], "to the bit");
}

#[test]
fn twin_of_the_draw_the_scores_and_the_fit() {
    if skipped() {
        return;
    }
    let config = Config { ground_z_m: 0.3, ..Config::default() };
    let mut random = Random(5);
    let truly = level_camera(0.6);
    let mut message = message(&config, &scene(), truly, truly);
    for sample in message.samples.iter_mut().filter(|sample| sample[3] > 0.0) {
        sample[2] += 0.02 * (random.unit() - 0.5);
    }
    let samples = message.twin_samples();
    let (planes, scores) = message.draw();
    let drawn = planes.iter().zip(&scores).filter(|(plane, _)| plane[2] > 0.0);
    let mut compared = 0;
    for (plane, &score) in drawn.clone() {
        let want = twin::score(slopes(*plane), &samples);
        assert!(want.abs_diff(score as usize) <= BORDER, "{plane:?}: {score}, {want}");
        compared += 1;
    }
    assert!(compared > 40, "{compared} planes of {HYPOTHESES}");
    let best = drawn.max_by_key(|(_, score)| **score).unwrap().0;
    let want = twin::refit(slopes(*best), &samples, DVec2::ZERO);
    let (told, _) = message.settle(&planes, &scores);
    let got = slopes(told.plane);
    let narrow = |plane: DVec3| plane.as_vec3().to_array();
    assert_close("plane", &narrow(got), &narrow(want), FIT);
    let [shown, pierced] = twin::squares(want, &samples, 0.25).map(|squares| squares as f32 / 16.0);
    assert!((told.areas_m2[0] - shown).abs() <= 0.25, "{:?}, {shown}", told.areas_m2);
    assert!((told.areas_m2[1] - pierced).abs() <= 0.25, "{:?}, {pierced}", told.areas_m2);
    let share = twin::score(want, &samples) as f32 / samples.len() as f32;
    assert!((told.share - share).abs() < 0.01, "{}, {share}", told.share);
}

#[test]
fn twin_of_samples_of_pixels_and_points_at_all_sizes() {
    if skipped() {
        return;
    }
    let config = Config::default();
    let place = Rigid { rotation: DQuat::from_rotation_y(0.2), translation_m: DVec3::new(3.0, 1.0, 1.2) };
    let pose = SensorPose { map_from_base: place, base_from_sensor: Rigid::IDENTITY, sweep: None };
    let mut random = Random(8);
    for points in [1_u32, 63, 64, 65, 2047, 2048, 2049, 5000] {
        let at: Vec<[f32; 3]> =
            (0..points).map(|_| [20.0, 20.0, 4.0].map(|size: f32| size * (random.unit() - 0.5))).collect();
        let words: Vec<[f32; 8]> = at.iter().map(|p| [p[0], p[1], p[2], 9.0, 0.0, 0.0, 0.0, 0.0]).collect();
        let params = params(&moment(&config, Sampled::Points(points), pose));
        let out = Fragment::new()
            .params("ground_params", &params)
            .texture("points", [POINT_ROW, (2 * points).div_ceil(POINT_ROW)], cast_slice(&words))
            .texture_output("ground_samples", SAMPLE_ROW, ROWS)
            .run(RETURNS, Invocations::line(MOST_SAMPLES));
        let got: Vec<[f32; 4]> = cast_slice(&out.floats("ground_samples")).to_vec();
        let all: Vec<Sample> = at
            .iter()
            .filter_map(|p| twin::sample(place.rotation * DVec3::from_array(p.map(f64::from))))
            .collect();
        let taken = got.iter().filter(|sample| sample[3] > 0.0);
        assert!(taken.clone().count() <= all.len() && taken.clone().count() * 8 >= all.len().min(2048) * 3);
        for sample in taken {
            let nearest = all.iter().map(|(at, _)| {
                (*at - DVec3::new(sample[0].into(), sample[1].into(), sample[2].into())).length()
            });
            assert!(nearest.fold(f64::INFINITY, f64::min) < PLACE.absolute, "{sample:?}");
        }
        if points <= MOST_SAMPLES {
            assert_eq!(got.iter().filter(|sample| sample[3] > 0.0).count(), all.len());
        }
    }
}

#[test]
fn a_table_and_what_lies_where_the_base_cannot_stand_are_refused() {
    if skipped() {
        return;
    }
    let config = Config::default();
    // A table top that fills the view but for its far end, and the floor beyond it.
    let table = Scene::of(&[Block::new([0.2, -1.5, 0.7], [2.0, 1.5, 0.75])]);
    let truly = pose(0.0, 0.0, 0.0, 1.3, 0.6);
    let (told, kept) = message(&config, &table, truly, truly).run();
    assert!(told.shown_as < 2.0 || (f64::from(told.plane[3]) + 1.3).abs() < 0.02, "{:?}", told.plane);
    assert!(kept[0][3] == 0.0 || kept[0][3].abs() < 0.02, "the table is not kept: {:?}", kept[0]);
    // A table top alone: nothing but the base, which stands far below it, speaks against it.
    let table = Scene::of(&[Block::new([-9.0, -9.0, 0.7], [9.0, 9.0, 0.75])]);
    let (told, kept) = message(&config, &table, truly, truly).run();
    assert_eq!((told.shown_as, told.source), (1.0, 0.0), "{:?}", told.plane);
    assert_eq!(kept[0], Kept::zeroed());
    assert_eq!(told.heights, [0.0, 0.0, 1.0, 0.0]);
}

#[test]
fn what_is_kept_outlives_messages_without_it_and_no_longer() {
    if skipped() {
        return;
    }
    let config = Config { ground_z_m: 0.3, ground_keep_s: 1.0, ..Config::default() };
    let truly = level_camera(0.6);
    let seen = message(&config, &scene(), truly, truly);
    let (told, kept) = seen.run();
    let blind = |tick: u32| Message {
        params: GroundParams { tick, ..seen.params },
        samples: vec![[0.0; 4]; seen.samples.len()],
        kept: kept.clone(),
    };
    let (later, still) = blind(7 + 100).run();
    assert_eq!((later.shown_as, later.source, later.heights), (0.0, 1.0, told.heights));
    assert_eq!(still, kept);
    let (late, _) = blind(7 + 101).run();
    assert_eq!((late.source, late.heights), (0.0, [0.0, 0.0, 1.0, 0.0]), "the stated ground again");
    // Of another sensor, which sees nothing, it is the ground too.
    let mut params = GroundParams { sensor: 1, sensors: 2, tick: 20, ..seen.params };
    params.local_from_sensor_z.w += 0.1;
    let other = Message { params, kept: vec![kept[0], Kept::zeroed()], ..blind(20) };
    let (told_other, _) = other.run();
    assert_eq!((told_other.source, told_other.heights), (2.0, told.heights));
    assert_close("height", &[told_other.sensor_height_m], &[0.7_f32], FIT);
}

#[test]
fn the_same_samples_give_the_same_bits() {
    if skipped() {
        return;
    }
    let config = Config { ground_z_m: 0.3, ..Config::default() };
    let truly = level_camera(0.6);
    let message = message(&config, &scene(), truly, truly);
    let first = message.run();
    let second = message.run();
    assert_eq!(first.1, second.1);
    assert_eq!(first.0.heights.map(f32::to_bits), second.0.heights.map(f32::to_bits));
}

#[test]
fn poison_and_nothing_are_no_ground() {
    if skipped() {
        return;
    }
    let config = Config::default();
    let camera = tiny_camera();
    let params = params(&moment(&config, Sampled::Pixels(camera), level_camera(0.6).into()));
    let pixels = (camera.width * camera.height) as usize;
    for poison in [0.0, -1.0, f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, f32::MIN_POSITIVE] {
        let samples = sampled_pixels(&camera, &params, &vec![poison; pixels], &vec![1.0; pixels]);
        assert!(samples.iter().all(|sample| sample[3] == 0.0), "{poison}");
        let (told, kept) = Message { params, samples, kept: vec![Kept::zeroed()] }.run();
        assert_eq!((told.shown_as, told.source, told.heights), (0.0, 0.0, [0.0, 0.0, 1.0, 0.0]));
        assert_eq!(kept[0], Kept::zeroed());
    }
    // Untrusted pixels are none.
    let depth_m =
        scene().depth(&camera, level_camera(0.6).map_from_base.then(level_camera(0.6).base_from_camera));
    let samples = sampled_pixels(&camera, &params, &depth_m, &vec![0.3; pixels]);
    assert!(samples.iter().all(|sample| sample[3] == 0.0));
}
