//! Reference depth and targets: reprojection, agreement, judgement, each by itself.

use bytemuck::Zeroable;
use glam::{DQuat, DVec3};
use limpid::base::Rigid;
use limpid::gpu::Invocations;
use limpid::network::Backend;
use limpid::sensor::{CameraModel, Distortion};
use limpid::stage::camera::back_project::rays;
use limpid::stage::camera::drm::{ResizeParams, resize};
use limpid::stage::targets::{
    AGREE, AgreeParams, JUDGE, REMEMBER, REPROJECT, RememberParams, ReprojectParams, Rule, VIEWS, View,
    judge_params, reproject_params,
};

use crate::reference;
use crate::support::camera_job::{job, small_map, tiny_camera};
use crate::support::compare::{EXACT, Tolerance, assert_close, compare};
use crate::support::gpu::{Fragment, SENTINEL, skipped};
use crate::support::random::Random;
use crate::support::scene::{Block, Scene, pose};

const ROUNDING: Tolerance =
    Tolerance { absolute: 2e-5, reason: "positions are float32, nearness has 27 fraction bits" };
const NEARNESS_ONE: f64 = 134_217_728.0;

fn depths(nearness: &[u32]) -> Vec<f64> {
    nearness.iter().map(|&n| if n == 0 { 0.0 } else { NEARNESS_ONE / f64::from(n) }).collect()
}

fn nearness(depth_m: f64) -> u32 {
    if depth_m > 0.0 { (NEARNESS_ONE / depth_m).round() as u32 } else { 0 }
}

fn lens() -> CameraModel {
    CameraModel { distortion: Distortion::PlumbBob([-0.1, 0.02, 0.001, -0.001, 0.0]), ..tiny_camera() }
}

/// `views` frames of one camera as another sees them: nearness, view by view.
fn reprojected(camera: CameraModel, frames: &[(Vec<f32>, Rigid)]) -> Vec<u32> {
    let job = job(&small_map(), camera);
    let views: Vec<View> = frames
        .iter()
        .enumerate()
        .map(|(slot, (_, target_from_view))| View { slot, target_from_view: *target_from_view })
        .collect();
    let slot = job.pixel_words() as usize * 4;
    let mut window = vec![0.0_f32; slot * frames.len()];
    for ((depth, _), into) in frames.iter().zip(window.chunks_mut(slot)) {
        into[..depth.len()].copy_from_slice(depth);
    }
    let out = Fragment::new()
        .params("reproject_params", &reproject_params(&job, &views))
        .input("window_m", &window)
        .input("rays", &rays(&camera))
        .changed("seen", &vec![0_u32; slot * frames.len()])
        .run(REPROJECT, Invocations([job.pixels(), frames.len() as u32, 1]));
    out.words("seen").to_vec()
}

/// Compares with the twin where f32 cannot see it otherwise; those are nearly all.
fn matches_twin(camera: &CameraModel, depth: &[f32], moved: Rigid, got: &[u32]) -> Result<(), String> {
    let want = reference::targets::reproject(camera, depth, moved);
    let sure: Vec<usize> = (0..want.len()).filter(|&i| !want[i].doubtful).collect();
    assert!(sure.len() * 10 > want.len() * 8, "{} of {} are sure", sure.len(), want.len());
    // Compared as 1 / depth, in which far depth is as exact as near.
    let inverse = |depth: f64| if depth > 0.0 { 1.0 / depth } else { 0.0 };
    let got: Vec<f64> = sure.iter().map(|&i| f64::from(got[i]) / NEARNESS_ONE).collect();
    let want: Vec<f64> = sure.iter().map(|&i| inverse(want[i].depth_m)).collect();
    compare("reprojected", &got, &want, ROUNDING)
}

fn moved(x: f64, y: f64, z: f64, yaw: f64) -> Rigid {
    Rigid { rotation: DQuat::from_rotation_y(yaw), translation_m: DVec3::new(x, y, z) }
}

#[test]
fn truth_a_frame_seen_from_its_own_place_is_itself() {
    if skipped() {
        return;
    }
    let camera = tiny_camera();
    let pixels = (camera.width * camera.height) as usize;
    let depth: Vec<f32> =
        (0..pixels).map(|i| if i % 7 == 0 { 0.0 } else { 1.0 + 0.001 * i as f32 }).collect();
    let got = reprojected(camera, &[(depth.clone(), Rigid::IDENTITY)]);
    assert_close("itself", &depths(&got), &depth, ROUNDING);
}

#[test]
fn truth_a_wall_comes_nearer_and_the_nearest_point_wins() {
    if skipped() {
        return;
    }
    // Half a metre forward: a wall 2 m away is 1.5 m away wherever it falls. A post in front of it covers what it meets.
    let camera = tiny_camera();
    let (width, pixels) = (camera.width as usize, (camera.width * camera.height) as usize);
    let depth: Vec<f32> =
        (0..pixels).map(|i| if (38..42).contains(&(i % width)) { 1.0 } else { 2.0 }).collect();
    let got = depths(&reprojected(camera, &[(depth, moved(0.0, 0.0, -0.5, 0.0))]));
    let seen: Vec<f64> = got.iter().copied().filter(|&d| d > 0.0).collect();
    assert!(seen.len() > pixels / 3);
    assert!(seen.iter().all(|d| (d - 1.5).abs() < 1e-4 || (d - 0.5).abs() < 1e-4));
    let post = (0..pixels).filter(|&i| (got[i] - 0.5).abs() < 1e-4).map(|i| i % width);
    assert!(post.clone().count() > 50 && post.clone().all(|u| (34..46).contains(&u)), "{:?}", post.max());
}

#[test]
fn reproject_is_its_twin_with_and_without_a_lens() {
    if skipped() {
        return;
    }
    let scene = Scene::of(&[Block::new([1.5, -0.5, 0.0], [2.0, 0.4, 0.6])]);
    for camera in [tiny_camera(), lens(), CameraModel { width: 65, height: 1, ..tiny_camera() }] {
        let place = pose(0.0, 0.0, 0.0, 0.6, 0.3);
        let depth = scene.depth(&camera, place.map_from_base.then(place.base_from_camera));
        let moves = [moved(0.03, 0.0, -0.1, 0.02), moved(-0.2, 0.05, 0.3, -0.1), moved(0.0, 0.0, 0.0, 3.0)];
        let frames: Vec<_> = moves.iter().map(|&m| (depth.clone(), m)).collect();
        let got = reprojected(camera, &frames);
        let slot = got.len() / moves.len();
        for (&by, got) in moves.iter().zip(got.chunks(slot)) {
            matches_twin(&camera, &depth, by, &got[..depth.len()]).unwrap();
        }
        // The control: another view is not taken for it.
        if camera.height > 1 {
            matches_twin(&camera, &depth, moves[1], &got[..depth.len()]).unwrap_err();
        }
    }
}

#[test]
fn reproject_keeps_poison_out() {
    if skipped() {
        return;
    }
    let camera = CameraModel { width: 8, height: 1, ..tiny_camera() };
    let poison = vec![f32::NAN, f32::INFINITY, -1.0, 0.0, f32::MAX, 1e-30, -0.0, f32::NEG_INFINITY];
    let far = Rigid { translation_m: DVec3::splat(1e30), ..Rigid::IDENTITY };
    for by in [Rigid::IDENTITY, moved(0.0, 0.0, -1.0, 0.0), far] {
        assert_eq!(reprojected(camera, &[(poison.clone(), by)]), [0; 8]);
    }
}

fn rule(least_views: u32) -> Rule {
    Rule { least_views, ..Rule::default() }
}

/// The reference of each pixel from its depths in up to 16 views.
fn agreed(pixels: &[Vec<f64>], rule: &Rule) -> Vec<f32> {
    let count = pixels.len().next_multiple_of(4);
    let mut seen = vec![0_u32; count * VIEWS];
    for (pixel, views) in pixels.iter().enumerate() {
        for (view, &depth) in views.iter().enumerate() {
            seen[view * count + pixel] = nearness(depth);
        }
    }
    let params = AgreeParams {
        pixels: pixels.len() as u32,
        slot_pixels: count as u32,
        least_views: rule.least_views,
        least_share: rule.least_share as f32,
        share: rule.share as f32,
        noise_per_m: rule.noise_per_m(&tiny_camera()) as f32,
        ..AgreeParams::zeroed()
    };
    let out = Fragment::new()
        .params("agree_params", &params)
        .changed("seen", &seen)
        .output("reference_m", pixels.len())
        .run(AGREE, Invocations::line(pixels.len() as u32));
    let after = out.words("seen").chunks(count).flat_map(|view| &view[..pixels.len()]);
    assert!(after.into_iter().all(|&word| word == 0), "emptied for the next frame");
    out.floats("reference_m")
}

#[test]
fn truth_a_reference_is_what_most_views_agree_on() {
    if skipped() {
        return;
    }
    let pixels = [
        vec![2.0, 2.01, 1.99, 2.0],
        vec![2.0, 2.01, 1.99, 2.0, 3.5, 9.0, 2.0],
        vec![2.0, 2.0, 2.0],                               // too few
        vec![2.0, 0.0, 2.0, 0.0, 2.0, 2.0],                // holes do not count
        vec![2.0, 2.0, 2.0, 2.0, 3.0, 3.1, 4.0, 5.0, 6.0], // less than half
        vec![1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0],      // a tie: the earlier
        vec![],
        vec![5.0; 16],
    ];
    let want = [2.0, 2.0, 0.0, 2.0, 0.0, 1.0, 0.0, 5.0];
    assert_close("references", &agreed(&pixels, &rule(4)), &want, ROUNDING);
    assert_close("of three", &agreed(&pixels[2..3], &rule(3)), &[2.0], ROUNDING);
}

#[test]
fn agree_is_its_twin_at_edge_sizes() {
    if skipped() {
        return;
    }
    let mut random = Random(3);
    for count in [1, 63, 64, 65, 200] {
        let pixels: Vec<Vec<f64>> = (0..count)
            .map(|_| {
                let surface = f64::from(0.5 + 6.0 * random.unit());
                let one = |random: &mut Random| match random.below(6) {
                    0 => 0.0,
                    1 => f64::from(0.3 + 9.0 * random.unit()),
                    _ => surface * (1.0 + 0.01 * f64::from(random.unit())),
                };
                let depths: Vec<f64> = (0..random.below(17)).map(|_| one(&mut random)).collect();
                // As the GPU has them, so that neither rounds across a border that the other does not.
                depths.iter().map(|&d| depths_of(nearness(d))).collect()
            })
            .collect();
        let want: Vec<f64> =
            pixels.iter().map(|views| reference::targets::agree(views, &rule(4), &tiny_camera())).collect();
        assert!(count < 60 || want.iter().filter(|&&d| d > 0.0).count() > count / 3);
        assert_close("references", &agreed(&pixels, &rule(4)), &want, ROUNDING);
    }
}

fn depths_of(nearness: u32) -> f64 {
    depths(&[nearness])[0]
}

const SHARE: f32 = 0.02;
const NOISE_PER_M: f32 = 0.0376;

fn judged(native: [u32; 2], size: [u32; 2], depth: &[f32], reference: &[f32]) -> (Vec<f32>, Vec<u32>) {
    let pixels = (size[0] * size[1]) as usize;
    let out = Fragment::new()
        .params("judge_params", &judge_params(native, size, [SHARE, NOISE_PER_M]))
        .input("window_m", depth)
        .input("reference_m", reference)
        .output("targets", pixels * 4)
        .output("picked", pixels)
        .run(JUDGE, Invocations::line(pixels as u32));
    (out.floats("targets"), out.words("picked").to_vec())
}

#[test]
fn truth_targets_by_hand() {
    if skipped() {
        return;
    }
    // At 1 m delta is 0.0752 by noise (2 x 0.0376); at 0.4 m it is 0.012 by noise, less, so 0.02 x 0.4 m or noise: 0.01203.
    let depth = [1.0, 1.07, 1.08, 0.0, 2.0, 0.4, 0.411, 0.413];
    let reference = [1.0, 1.0, 1.0, 1.0, 0.0, 0.4, 0.4, 0.4];
    let (targets, picked) = judged([1, 8], [1, 8], &depth, &reference);
    let soft = |error: f32, reference: f32| (-error / (SHARE * reference)).exp();
    let want = [
        [1.0, 1.0, 1.0, 1.0],
        [1.0, soft(0.07, 1.0), 1.0, 1.07],
        [1.0, soft(0.08, 1.0), 0.0, 1.08],
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 2.0],
        [0.4, 1.0, 1.0, 0.4],
        [0.4, soft(0.011, 0.4), 1.0, 0.411],
        [0.4, soft(0.013, 0.4), 0.0, 0.413],
    ];
    assert_close("targets", &targets, want.as_flattened(), ROUNDING);
    assert_eq!(picked, [0, 1, 2, 3, 4, 5, 6, 7]);
}

const SIZES: [([u32; 2], [u32; 2]); 7] = [
    ([48, 64], [24, 32]),
    ([48, 84], [24, 32]),
    ([45, 53], [16, 16]),
    ([12, 16], [24, 32]),
    ([1, 1], [4, 4]),
    ([3, 130], [4, 4]),
    ([64, 65], [64, 64]),
];

#[test]
fn judge_is_its_twin_and_takes_the_depth_that_resize_takes() {
    if skipped() {
        return;
    }
    let mut random = Random(5);
    for (native, size) in SIZES {
        let (count, pixels) = ((native[0] * native[1]) as usize, (size[0] * size[1]) as usize);
        let depth: Vec<f32> =
            (0..count).map(|_| if random.chance(0.4) { 0.0 } else { 0.2 + 9.0 * random.unit() }).collect();
        let near = |d: f32, random: &mut Random| d.max(0.3) * (0.9 + 0.2 * random.unit());
        let reference: Vec<f32> =
            depth.iter().map(|&d| if random.chance(0.2) { 0.0 } else { near(d, &mut random) }).collect();
        let (targets, picked) = judged(native, size, &depth, &reference);
        let whole = |s: [u32; 2]| s.map(|v| v as usize);
        let rule = [f64::from(SHARE), f64::from(NOISE_PER_M)];
        let twin: Vec<_> = (0..pixels)
            .map(|p| reference::targets::judge(whole(native), whole(size), p, &depth, &reference, rule))
            .collect();
        let (want, want_picked): (Vec<[f64; 4]>, Vec<u32>) =
            twin.into_iter().map(|(quad, index)| (quad, index as u32)).unzip();
        assert_eq!(picked, want_picked, "{native:?} to {size:?}");
        assert_close(&format!("{native:?} to {size:?}"), &targets, want.as_flattened(), ROUNDING);
        let taken: Vec<f32> = targets.chunks(4).map(|quad| quad[3]).collect();
        assert_eq!(taken, resized_depth(native, size, &depth), "{native:?} to {size:?}");
    }
}

/// The depth that the network's own input is made of.
fn resized_depth(native: [u32; 2], size: [u32; 2], depth: &[f32]) -> Vec<f32> {
    let (text, invocations) = resize(native, size, Backend { textures: false, subgroups: false });
    let pixels = (size[0] * size[1]) as usize;
    let out = Fragment::new()
        .params("resize_params", &ResizeParams { per_metre: 0.1, change_per_metre: 0.1, pad1: 0, pad2: 0 })
        .input("depth_m", depth)
        .input("color", &vec![0xff00_0000_u32; depth.len()])
        .changed("depth_before", &vec![0.0_f32; pixels])
        .output("sink", pixels * 8)
        .run(text, invocations);
    out.floats("depth_before")
}

#[test]
fn judge_keeps_poison_out() {
    if skipped() {
        return;
    }
    let reference = [f32::NAN, f32::INFINITY, -1.0, f32::MAX, 0.0, f32::NEG_INFINITY, 1e-30, 1.0];
    let (targets, _) = judged([1, 8], [1, 8], &[1.0; 8], &reference);
    assert!(targets.iter().all(|t| t.is_finite()), "{targets:?}");
    let binary: Vec<f32> = targets.chunks(4).map(|quad| quad[2]).collect();
    assert_eq!(binary, [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn remember_writes_its_slot_and_no_other() {
    if skipped() {
        return;
    }
    for words in [1_u32, 63, 64, 65] {
        let depth: Vec<f32> = (0..4 * words).map(|i| i as f32).collect();
        let out = Fragment::new()
            .params("remember_params", &RememberParams { words, slot: 1, pad0: 0, pad1: 0 })
            .input("depth_m", &depth)
            .output("window_m", 12 * words as usize)
            .run(REMEMBER, Invocations::line(words));
        let slots: Vec<&[u32]> = out.words("window_m").chunks(4 * words as usize).collect();
        assert!(slots[0].iter().chain(slots[2]).all(|&word| word == SENTINEL));
        let kept: Vec<f32> = slots[1].iter().map(|&word| f32::from_bits(word)).collect();
        assert_close("slot", &kept, &depth, EXACT);
    }
}

#[test]
fn nothing_to_do_is_refused() {
    let nothing = ReprojectParams::zeroed();
    let fragment = Fragment::new()
        .params("reproject_params", &nothing)
        .input("window_m", &[0.0_f32; 4])
        .input("rays", &[0.0_f32; 8])
        .changed("seen", &[0_u32; 4]);
    fragment.refuses_nothing(REPROJECT);
}
