//! Depth pixels into cells.

use bytemuck::cast_slice;
use glam::{DQuat, DVec3, Vec2};
use limpid::Config;
use limpid::base::Rigid;
use limpid::gpu::Invocations;
use limpid::sensor::{CameraModel, Distortion};
use limpid::stage::camera::back_project::{BACK_PROJECT, BackProjectParams, STRIP, rays};
use limpid::stage::camera::see_through::TILE;
use limpid::stage::ground::stated_now;
use limpid::stage::rows;

use crate::reference;
use crate::support::camera_job::{job, small_map, tiny_camera, view};
use crate::support::compare::{EXACT, Tolerance, assert_close};
use crate::support::gpu::{Fragment, Outputs, skipped};
use crate::support::random::Random;
use crate::support::scene::{Block, Scene, pose};

const HEIGHT: Tolerance =
    Tolerance { absolute: 4e-5, reason: "steps of 1/65536 m, and f32 at a few metres rounds by 1e-6 m" };

/// Valid pixels, those of low reliability, and hits.
fn counts(out: &Outputs) -> [u32; 3] {
    [0, 8, 16].map(|shift| out.words("strip_counts").iter().map(|word| word >> shift & 0xff).sum())
}

/// What `top` holds where only the floor was met; heights follow above it.
const FLOOR: u32 = 1;

struct View<'a> {
    config: &'a Config,
    camera: CameraModel,
    window_from_camera: Rigid,
    depth_m: &'a [f32],
    reliability: &'a [f32],
}

impl View<'_> {
    fn side(&self) -> usize {
        self.config.cells_per_side().unwrap() as usize
    }

    fn fragment(&self) -> Fragment {
        let [x, y, z] = rows(self.window_from_camera);
        let params = BackProjectParams {
            window_from_camera_x: x,
            window_from_camera_y: y,
            window_from_camera_z: z,
            width: self.camera.width,
            height: self.camera.height,
            side: self.side() as u32,
            resolution_m: self.config.resolution_m as f32,
            mark_range_m: self.config.mark_range_m as f32,
            height_min_m: self.config.height_min_m as f32,
            height_max_m: self.config.height_max_m as f32,
            tau: self.config.tau as f32,
            weight_scale: job(self.config, self.camera).weight_scale(),
            pad: 0,
            focal_px: Vec2::new(self.camera.fx as f32, self.camera.fy as f32),
            centre_px: Vec2::new(self.camera.cx as f32, self.camera.cy as f32),
            groups: self.groups(),
            groups_y: self.camera.height.div_ceil(STRIP),
        };
        let [width, height] = [self.camera.width, self.camera.height].map(|size| size as usize);
        Fragment::new()
            .params("back_project_params", &params)
            .input("ground_now", &stated_now(0.0))
            .input("depth_m", self.depth_m)
            .input("reliability", self.reliability)
            .input("rays", &rays(&self.camera))
            .changed("cell_hits", &vec![[0_u32; 4]; self.side() * self.side()])
            .output("strip_counts", width * height.div_ceil(STRIP as usize))
            .output("strip_far_m", width * height.div_ceil(TILE as usize))
    }

    fn groups(&self) -> u32 {
        self.camera.width.div_ceil(64) * self.camera.height.div_ceil(STRIP)
    }

    fn run(&self) -> Outputs {
        self.fragment().run(BACK_PROJECT, Invocations::line(self.groups() * 64))
    }

    fn twin(&self) -> Vec<reference::back_project::Hits> {
        let (camera, transform) = (&self.camera, self.window_from_camera);
        reference::back_project::back_project(
            self.config,
            self.side(),
            camera,
            transform,
            self.depth_m,
            self.reliability,
        )
    }
}

fn cells(out: &Outputs) -> Vec<[u32; 4]> {
    cast_slice(out.words("cell_hits")).to_vec()
}

/// A camera that looks along +x from the middle of the small map, 1 m up.
fn level(camera: CameraModel, config: &Config, depth_m: &[f32]) -> Vec<[u32; 4]> {
    let (window_from_camera, _) = view(&Scene::default(), &camera, pose(0.01, 0.02, 0.0, 1.0, 0.0), 3.0);
    let reliability = vec![1.0; depth_m.len()];
    cells(&View { config, camera, window_from_camera, depth_m, reliability: &reliability }.run())
}

fn one_pixel() -> CameraModel {
    CameraModel { width: 1, height: 1, fx: 100.0, fy: 100.0, cx: 0.0, cy: 0.0, distortion: Distortion::None }
}

#[test]
fn truth_a_wall_marks_the_cells_it_stands_in() {
    if skipped() {
        return;
    }
    let config = small_map();
    let scene = Scene::of(&[Block::new([2.02, -9.0, 0.0], [2.3, 9.0, 3.0])]);
    let camera = tiny_camera();
    let (window_from_camera, depth_m) = view(&scene, &camera, pose(0.01, 0.02, 0.0, 1.0, 0.0), 3.0);
    let reliability = vec![1.0; depth_m.len()];
    let view =
        View { config: &config, camera, window_from_camera, depth_m: &depth_m, reliability: &reliability };
    let out = view.run();
    let column = ((2.02 + 3.0) / 0.05_f64) as usize;
    let hit: Vec<usize> = (0..120 * 120).filter(|&i| cells(&out)[i][0] > 0).collect();
    assert!(hit.len() > 30 && hit.iter().all(|i| i % 120 == column), "only the wall's face: {hit:?}");
    assert_eq!(counts(&out), [80 * 60, 0, cells(&out).iter().map(|c| c[0]).sum::<u32>()]);
}

#[test]
fn truth_one_pixel_at_a_time() {
    if skipped() {
        return;
    }
    let config = small_map();
    let index = |x: f64| (60 * 120) + ((x + 0.01 + 3.0) / 0.05) as usize;
    let scale = job(&config, one_pixel()).weight_scale();
    let hit = level(one_pixel(), &config, &[2.0]);
    let steps = ((1.0 - 0.1_f32) * 65536.0) as u32 + FLOOR + 1;
    assert_eq!(hit[index(2.0)], [1, scale as u32, steps, 0]);
    assert!(hit.iter().enumerate().all(|(i, c)| i == index(2.0) || *c == [0; 4]));
    let near = Config { mark_range_m: 2.0, ..config.clone() };
    assert_eq!(level(one_pixel(), &near, &[1.999])[index(1.999)][0], 1);
    assert!(level(one_pixel(), &near, &[2.001]).iter().all(|c| *c == [0; 4]), "beyond the mark range");
    let low = Config { height_max_m: 0.9, ..config };
    assert!(level(one_pixel(), &low, &[2.0]).iter().all(|c| *c == [0; 4]), "above the band");
}

#[test]
fn truth_tau_itself_is_not_trusted() {
    if skipped() {
        return;
    }
    let config = Config { tau: 0.5, ..small_map() };
    let (window_from_camera, _) = view(&Scene::default(), &one_pixel(), pose(0.01, 0.02, 0.0, 1.0, 0.0), 3.0);
    for (weight, hits) in [(0.5, 0), (0.500_1, 1), (0.0, 0)] {
        let view = View {
            config: &config,
            camera: one_pixel(),
            window_from_camera,
            depth_m: &[2.0],
            reliability: &[weight],
        };
        let out = view.run();
        assert_eq!(counts(&out), [1, 1 - hits, hits], "weight {weight}");
        assert_eq!(cells(&out).iter().map(|c| c[0]).sum::<u32>(), hits);
    }
}

fn compare_with_twin(view: &View) {
    let (got, want) = (cells(&view.run()), view.twin());
    let sure: Vec<usize> = (0..want.len()).filter(|&i| !want[i].doubtful).collect();
    let touched = want.iter().filter(|hits| hits.count > 0 || hits.floor).count();
    let doubtful = want.len() - sure.len();
    assert!(touched > 100 && doubtful * 20 < touched, "{doubtful} doubtful of {touched}");
    let scale = f64::from(job(view.config, view.camera).weight_scale());
    let pick = |f: &dyn Fn(usize) -> f64| sure.iter().map(|&i| f(i)).collect::<Vec<f64>>();
    assert_close("count", &pick(&|i| got[i][0].into()), &pick(&|i| want[i].count.into()), EXACT);
    let floor = |i: usize| f64::from(want[i].floor && want[i].count == 0);
    assert_close("floor", &pick(&|i| f64::from(got[i][2] == FLOOR)), &pick(&floor), EXACT);
    let most = want.iter().map(|hits| hits.count).max().unwrap();
    let rounding =
        Tolerance { absolute: f64::from(most) * 0.51 / scale, reason: "half a step of 1/scale per hit" };
    let weight = |i: usize| f64::from(got[i][1]) / scale;
    assert_close("weight", &pick(&weight), &pick(&|i| want[i].weight), rounding);
    let top =
        |i: usize| if got[i][2] <= FLOOR { 0.0 } else { f64::from(got[i][2] - FLOOR - 1) / 65536.0 + 0.1 };
    assert_close("top", &pick(&top), &pick(&|i| want[i].top_m), HEIGHT);
}

#[test]
fn twin_on_a_room() {
    if skipped() {
        return;
    }
    let scene = Scene::of(&[
        Block::new([2.31, -3.0, 0.0], [2.5, 3.0, 2.5]),
        Block::new([1.21, 0.11, 0.0], [1.51, 0.61, 0.35]),
        Block::new([1.01, -1.01, 0.7], [1.81, -0.21, 0.75]),
    ]);
    let mut random = Random(21);
    let distorted =
        CameraModel { distortion: Distortion::PlumbBob([0.1, -0.05, 1e-3, 2e-3, 0.01]), ..tiny_camera() };
    let config = small_map();
    for (camera, yaw, pitch) in [(tiny_camera(), 0.3, 0.3), (distorted, -2.2, 0.5), (distorted, 0.1, 0.2)] {
        let (window_from_camera, depth_m) = view(&scene, &camera, pose(0.013, 0.021, yaw, 0.6, pitch), 3.0);
        let reliability: Vec<f32> = depth_m.iter().map(|_| random.unit()).collect();
        compare_with_twin(&View {
            config: &config,
            camera,
            window_from_camera,
            depth_m: &depth_m,
            reliability: &reliability,
        });
    }
}

#[test]
fn twin_of_the_farthest_trusted_depths() {
    if skipped() {
        return;
    }
    let (config, mut random) = (small_map(), Random(22));
    let camera = CameraModel { width: 13, height: 21, ..tiny_camera() };
    let depth_m: Vec<f32> = (0..13 * 21).map(|_| random.unit() * 5.0).collect();
    let reliability: Vec<f32> = depth_m.iter().map(|_| random.unit()).collect();
    let (window_from_camera, _) = view(&Scene::default(), &camera, pose(0.0, 0.0, 0.0, 1.0, 0.0), 3.0);
    let view =
        View { config: &config, camera, window_from_camera, depth_m: &depth_m, reliability: &reliability };
    let farthest = |strip: usize| {
        let (x, rows) = (strip % 13, strip / 13 * 8..(strip / 13 * 8 + 8).min(21));
        let trusted = rows.map(|y| y * 13 + x).filter(|&i| reliability[i] > 0.3);
        trusted.map(|i| depth_m[i]).fold(0.0, f32::max)
    };
    let want: Vec<f32> = (0..13 * 3).map(farthest).collect();
    assert_close("farthest", &view.run().floats("strip_far_m"), &want, EXACT);
}

#[test]
fn the_specialised_passes_give_the_same() {
    if skipped() {
        return;
    }
    let config = small_map();
    let scene = Scene::of(&[Block::new([1.21, 0.11, 0.0], [1.51, 0.61, 0.35])]);
    let (window_from_camera, depth_m) = view(&scene, &tiny_camera(), pose(0.013, 0.021, 0.3, 0.6, 0.3), 3.0);
    let reliability: Vec<f32> = depth_m.iter().map(|&d| if d > 0.0 { 1.0 } else { 0.0 }).collect();
    let view = View {
        config: &config,
        camera: tiny_camera(),
        window_from_camera,
        depth_m: &depth_m,
        reliability: &reliability,
    };
    let general = view.run();
    for constants in [[("weighted", false), ("distorted", true)], [("weighted", false), ("distorted", false)]]
    {
        let lines = Invocations::line(view.groups() * 64);
        let special = view.fragment().constants(&constants).run(BACK_PROJECT, lines);
        let of = |out: &Outputs, word: usize| cells(out).iter().map(|c| c[word]).collect::<Vec<_>>();
        assert_eq!(of(&special, 0), of(&general, 0), "hits, {constants:?}");
        assert!(of(&special, 1).iter().all(|&weight| weight == 0), "no weights are summed");
        assert_eq!(special.words("strip_far_m"), general.words("strip_far_m"));
        assert_eq!(counts(&special), counts(&general));
    }
}

#[test]
fn twin_of_the_lowest_hits() {
    if skipped() {
        return;
    }
    let scene = Scene::of(&[
        Block::new([2.31, -3.0, 0.0], [2.5, 3.0, 2.5]),
        Block::new([1.21, 0.11, 0.0], [1.51, 0.61, 0.35]),
    ]);
    let (config, camera) = (small_map(), tiny_camera());
    let (window_from_camera, depth_m) = view(&scene, &camera, pose(0.013, 0.021, 0.3, 0.6, 0.3), 3.0);
    let reliability: Vec<f32> = depth_m.iter().map(|&d| if d > 0.0 { 0.9 } else { 0.0 }).collect();
    let view =
        View { config: &config, camera, window_from_camera, depth_m: &depth_m, reliability: &reliability };
    let lines = Invocations::line(view.groups() * 64);
    let run = |constants: &[(&'static str, bool)]| {
        cells(&view.fragment().constants(constants).run(BACK_PROJECT, lines))
    };
    let (got, want) = (run(&[("lowest", true)]), view.twin());
    let sure: Vec<usize> = (0..want.len()).filter(|&i| !want[i].doubtful && want[i].count > 0).collect();
    assert!(sure.len() > 50, "{}", sure.len());
    let low: Vec<f64> = sure.iter().map(|&i| f64::from(!got[i][3] - FLOOR - 1) / 65536.0 + 0.1).collect();
    let twin: Vec<f64> = sure.iter().map(|&i| want[i].low_m).collect();
    assert_close("lowest", &low, &twin, HEIGHT);
    assert!(got.iter().all(|c| (c[0] > 0) == (c[3] > 0)), "floor points are no hits");
    let without = |cells: Vec<[u32; 4]>| cells.iter().map(|c| [c[0], c[1], c[2]]).collect::<Vec<_>>();
    assert_eq!(without(got.clone()), without(run(&[])), "the rest stays as it is");
    assert!(run(&[]).iter().all(|c| c[3] == 0));
    let gated = run(&[("lowest", true), ("gated", true)]);
    assert_eq!(without(gated), without(got), "a lidar asks for the weights of gated hits too");
}

#[test]
fn truth_depths_to_a_pane_mark_nothing_and_reach_as_far() {
    if skipped() {
        return;
    }
    let (config, camera) = (small_map(), CameraModel { width: 4, height: 3, ..one_pixel() });
    let (window_from_camera, _) = view(&Scene::default(), &camera, pose(0.01, 0.02, 0.0, 1.0, 0.0), 3.0);
    let depth_m = [-2.0, -1.5, 1.0, 0.0, -0.5, -1.0, -2.0, -0.0, -3.0, -1.0, -2.0, 1.25];
    let reliability = [1.0; 12];
    let view =
        View { config: &config, camera, window_from_camera, depth_m: &depth_m, reliability: &reliability };
    for weighted in [true, false] {
        let lines = Invocations::line(view.groups() * 64);
        let out = view.fragment().constants(&[("weighted", weighted)]).run(BACK_PROJECT, lines);
        assert_eq!(out.floats("strip_far_m"), [3.0, 1.5, 2.0, 1.25]);
        assert_eq!(cells(&out).iter().map(|c| c[0]).sum::<u32>(), 2, "the pixels with depths of their own");
        assert_eq!(counts(&out)[0], 10, "ten have depth");
    }
}

#[test]
fn edge_sizes() {
    if skipped() {
        return;
    }
    let config = small_map();
    let turned = Rigid { rotation: DQuat::IDENTITY, translation_m: DVec3::ZERO };
    let none = View {
        config: &config,
        camera: one_pixel(),
        window_from_camera: turned,
        depth_m: &[1.0],
        reliability: &[1.0],
    };
    none.fragment().refuses_nothing(BACK_PROJECT);
    for (width, height) in [(1, 1), (63, 15), (64, 16), (65, 17), (1, 33), (129, 1)] {
        let camera = CameraModel {
            width,
            height,
            fx: 90.0,
            fy: 90.0,
            cx: f64::from(width) / 2.0,
            cy: f64::from(height) / 2.0,
            distortion: Distortion::None,
        };
        let hits = level(camera, &config, &vec![2.0; (width * height) as usize]);
        assert_eq!(hits.iter().map(|c| c[0]).sum::<u32>(), width * height, "{width}x{height}");
    }
}

#[test]
fn all_pixels_in_one_cell_do_not_overflow() {
    if skipped() {
        return;
    }
    let camera = CameraModel {
        width: 848,
        height: 480,
        fx: 1e6,
        fy: 1e6,
        cx: 424.0,
        cy: 240.0,
        distortion: Distortion::None,
    };
    let hits = level(camera, &small_map(), &vec![1.99; 848 * 480]);
    let scale = job(&small_map(), camera).weight_scale();
    let full: Vec<_> = hits.iter().filter(|c| c[0] > 0).collect();
    assert_eq!(full.len(), 1);
    assert_eq!((full[0][0], scale), (407_040, 8192.0), "13 fraction bits, as the specification says");
    assert_eq!(u64::from(full[0][1]), 407_040 * 8192);
}

#[test]
fn poison_marks_nothing() {
    if skipped() {
        return;
    }
    let camera = CameraModel { width: 8, ..one_pixel() };
    let poison = [0.0, -1.0, f32::NEG_INFINITY, 1e30, f32::MAX, 1e-30, -0.0, 65.535];
    let hits = level(camera, &small_map(), &poison);
    assert!(hits.iter().all(|c| c[0] <= 1), "{hits:?}");
    let marked: Vec<usize> = (0..hits.len()).filter(|&i| hits[i][0] > 0).collect();
    assert_eq!(marked, [60 * 120 + 60], "only 1e-30 m in front of the camera is in range");
    let nan_camera = CameraModel { distortion: Distortion::RationalPolynomial([9.0; 8]), ..camera };
    let outside = level(nan_camera, &small_map(), &[2.0; 8]);
    assert!(outside.iter().map(|c| c[0]).sum::<u32>() <= 8);
}
