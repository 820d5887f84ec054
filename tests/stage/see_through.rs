//! Cells that trusted rays cross before they end.
//!
//! The shader gathers along the vertical through a cell's centre; the reference tries every ray on the whole
//! square. They may differ only where the answer changes from a cell to the next.

use glam::{DVec2, DVec3, Vec2, Vec4};
use limpid::Config;
use limpid::base::Rigid;
use limpid::gpu::Invocations;
use limpid::sensor::{CameraModel, Distortion};
use limpid::stage::camera::see_through::{
    AROUND, GATHER, SeeThroughAroundParams, SeeThroughGatherParams, SeeThroughTilesParams, TILES, field,
};
use limpid::stage::ground::stated_now;
use limpid::stage::rows;

use crate::reference::see_through::{Ray, seen_through, trusted_rays};
use crate::support::camera_job::{small_map, tiny_camera, view};
use crate::support::compare::{EXACT, assert_close};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;
use crate::support::scene::{Block, Scene, pose, small_camera};

/// Share of the cells away from borders in which gather and truth may differ.
const DISAGREEMENT: f64 = 0.001;

/// Share in which they may differ at borders, where a ray crosses a corner of the cell and not its middle.
const AT_BORDERS: f64 = 0.08;

pub(super) struct View {
    pub(super) config: Config,
    pub(super) camera: CameraModel,
    pub(super) window_from_camera: Rigid,
    pub(super) depth_m: Vec<f32>,
    pub(super) reliability: Vec<f32>,
    /// Highest hit recorded in every cell, metres; none where nothing is.
    top_m: Option<f64>,
}

impl View {
    pub(super) fn of(scene: &Scene, camera: CameraModel, yaw: f64, height_m: f64, pitch: f64) -> Self {
        let (window_from_camera, depth_m) =
            view(scene, &camera, pose(0.013, 0.021, yaw, height_m, pitch), 3.0);
        let reliability = depth_m.iter().map(|&d| if d > 0.0 { 1.0 } else { 0.0 }).collect();
        Self { config: small_map(), camera, window_from_camera, depth_m, reliability, top_m: None }
    }

    pub(super) fn params(&self) -> SeeThroughGatherParams {
        let [x, y, z] = rows(self.window_from_camera.inverse());
        let k = self.camera.distortion.coefficients().map(|k| k as f32);
        let [field_min, field_max] = field(&self.camera);
        let CameraModel { fx, fy, cx, cy, .. } = self.camera;
        SeeThroughGatherParams {
            camera_from_window_x: x,
            camera_from_window_y: y,
            camera_from_window_z: z,
            lens_a: Vec4::new(k[0], k[1], k[2], k[3]),
            lens_b: Vec4::new(k[4], k[5], k[6], k[7]),
            focal_px: Vec2::new(fx as f32, fy as f32),
            centre_px: Vec2::new(cx as f32, cy as f32),
            field_min,
            field_max,
            camera_xy_m: self.window_from_camera.translation_m.truncate().as_vec2(),
            width: self.camera.width,
            height: self.camera.height,
            side: self.side() as u32,
            origin_slot_x: 0,
            origin_slot_y: 0,
            min_hits: self.config.min_hits,
            resolution_m: self.config.resolution_m as f32,
            mark_range_m: self.config.mark_range_m as f32,
            height_min_m: self.config.height_min_m as f32,
            height_max_m: self.config.height_max_m as f32,
            tau: self.config.tau as f32,
            tiles_x: self.camera.width.div_ceil(8),
            first_x: 0,
            first_y: 0,
        }
    }

    pub(super) fn side(&self) -> usize {
        self.config.cells_per_side().unwrap() as usize
    }

    fn fragment(&self, hits: &[[u32; 4]]) -> Fragment {
        let cells = self.side() * self.side();
        let steps = self.top_m.map_or(0, |top| ((top - self.config.height_min_m) * 65536.0) as u32 + 2);
        Fragment::new()
            .constants(&[("fisheye", self.camera.distortion.is_fisheye())])
            .params("see_through_gather_params", &self.params())
            .input("ground_now", &stated_now(0.0))
            .input("depth_m", &self.depth_m)
            .input("reliability", &self.reliability)
            .input("cells", &vec![[0, 0, 0, steps]; cells])
            .input("cell_hits", hits)
            .input("around_far_m", &self.around())
            .changed("seen_through", &vec![0_u32; cells])
    }

    /// Farthest trusted depth of each strip of eight pixels down a column.
    fn strips(&self) -> Vec<f32> {
        let (width, height) = (self.camera.width as usize, self.camera.height as usize);
        let trusted = |i: usize| f64::from(self.reliability[i]) > self.config.tau;
        let farthest = |strip: usize| {
            let rows = strip / width * 8..(strip / width * 8 + 8).min(height);
            let pixels = rows.map(|y| y * width + strip % width).filter(|&i| trusted(i));
            pixels.map(|i| self.depth_m[i]).fold(0.0, f32::max)
        };
        (0..width * height.div_ceil(8)).map(farthest).collect()
    }

    /// Farthest trusted depth in and around each tile of 8x8 pixels.
    fn around(&self) -> Vec<f32> {
        let (width, height) = (self.camera.width as usize, self.camera.height as usize);
        let (tiles_x, tiles_y) = (width.div_ceil(8), height.div_ceil(8));
        let strips = self.strips();
        let farthest = |tile: usize| {
            let (x, y) = (tile % tiles_x, tile / tiles_x);
            let columns = (8 * x).saturating_sub(8)..(8 * x + 16).min(width);
            let rows = y.saturating_sub(1)..(y + 2).min(tiles_y);
            rows.flat_map(|row| strips[row * width..][columns.clone()].to_vec()).fold(0.0, f32::max)
        };
        (0..tiles_x * tiles_y).map(farthest).collect()
    }

    fn gather_with(&self, hits: &[[u32; 4]]) -> Vec<bool> {
        let side = self.side() as u32;
        let out = self.fragment(hits).run(GATHER, Invocations::area(side, side));
        assert!(out.words("seen_through").iter().all(|&seen| seen < 2));
        out.words("seen_through").iter().map(|&seen| seen == 1).collect()
    }

    fn gather(&self) -> Vec<bool> {
        self.gather_with(&vec![[0; 4]; self.side() * self.side()])
    }

    fn truth(&self) -> Vec<bool> {
        let (config, camera) = (&self.config, &self.camera);
        let rays = trusted_rays(config, camera, self.window_from_camera, &self.depth_m, &self.reliability);
        let corner =
            |i: usize| DVec2::new((i % self.side()) as f64, (i / self.side()) as f64) * config.resolution_m;
        (0..self.side() * self.side()).map(|i| seen_through(config, &rays, corner(i), self.top_m)).collect()
    }

    /// Cells that differ away from the truth's borders, those that differ at all, those that the gather alone
    /// sees through, and those that the truth sees through.
    fn disagreement(&self) -> [usize; 4] {
        let (got, want) = (self.gather(), self.truth());
        let differing: Vec<usize> = (0..want.len()).filter(|&i| got[i] != want[i]).collect();
        let inner = differing.iter().filter(|&&i| !at_border(&want, self.side(), i)).count();
        let invented = differing.iter().filter(|&&i| got[i]).count();
        [inner, differing.len(), invented, want.iter().filter(|seen| **seen).count()]
    }
}

/// Whether a neighbour of cell `i` has another answer.
fn at_border(answers: &[bool], side: usize, i: usize) -> bool {
    let (x, y) = (i % side, i / side);
    let rows = y.saturating_sub(1)..=(y + 1).min(side - 1);
    let mut near =
        rows.flat_map(|row| (x.saturating_sub(1)..=(x + 1).min(side - 1)).map(move |c| row * side + c));
    near.any(|n| answers[n] != answers[i])
}

pub(super) fn room() -> Scene {
    Scene::of(&[
        Block::new([2.31, -3.0, 0.0], [2.51, 3.0, 2.5]),
        Block::new([1.21, 0.11, 0.0], [1.51, 0.61, 0.35]),
        Block::new([1.01, -1.01, 0.7], [1.81, -0.21, 0.75]),
    ])
}

#[test]
fn truth_brute_force_over_all_rays() {
    if skipped() {
        return;
    }
    let lens =
        CameraModel { distortion: Distortion::PlumbBob([0.1, -0.05, 1e-3, 2e-3, 0.01]), ..small_camera() };
    // 124 degrees wide.
    let fisheye = CameraModel {
        fx: 74.0,
        fy: 74.0,
        distortion: Distortion::Fisheye([0.02, -0.01, 0.004, -0.001]),
        ..small_camera()
    };
    let mut totals = [0; 4];
    for (camera, yaw, height_m, pitch) in [
        (small_camera(), 0.0, 0.6, 0.2),
        (small_camera(), 2.4, 1.4, 0.7),
        (small_camera(), -0.3, 0.3, 0.0),
        (lens, 0.4, 0.6, 0.3),
        (fisheye, 0.2, 0.6, 0.3),
    ] {
        let counts = View::of(&room(), camera, yaw, height_m, pitch).disagreement();
        println!("yaw {yaw}: {counts:?} (away from borders, in all, too much, seen through)");
        totals = [0, 1, 2, 3].map(|i| totals[i] + counts[i]);
    }
    let [inner, all, invented, seen] = totals;
    assert!(seen > 3000, "the scenes show {seen} cells");
    assert!(inner as f64 <= DISAGREEMENT * seen as f64, "{totals:?}");
    assert!(invented as f64 <= DISAGREEMENT * seen as f64, "clears what no ray crosses: {totals:?}");
    assert!(all as f64 <= AT_BORDERS * seen as f64, "{totals:?}");
}

#[test]
fn twin_of_the_tiles() {
    if skipped() {
        return;
    }
    let mut random = Random(61);
    for (width, height) in [(80, 60), (1, 1), (7, 9), (65, 33), (129, 8)] {
        let camera = CameraModel { width, height, ..tiny_camera() };
        let mut view = View::of(&room(), camera, 0.0, 0.6, 0.2);
        view.depth_m.iter_mut().for_each(|d| *d = random.unit() * 5.0);
        view.reliability.iter_mut().for_each(|r| *r = random.unit());
        let (tiles_x, tiles_y) = (width.div_ceil(8), height.div_ceil(8));
        let count = (tiles_x * tiles_y) as usize;
        let tiles = Fragment::new()
            .params("see_through_tiles_params", &SeeThroughTilesParams { width, tiles_x, tiles_y, pad: 0 })
            .input("strip_far_m", &view.strips())
            .output("tile_far_m", count)
            .run(TILES, Invocations::area(tiles_x, tiles_y));
        let around = Fragment::new()
            .params("see_through_around_params", &SeeThroughAroundParams { tiles_x, tiles_y })
            .input("tile_far_m", &tiles.floats("tile_far_m"))
            .output("around_far_m", count)
            .run(AROUND, Invocations::area(tiles_x, tiles_y));
        assert_close("around", &around.floats("around_far_m"), &view.around(), EXACT);
    }
}

#[test]
fn control_the_reference_turns_red() {
    if skipped() {
        return;
    }
    let mut view = View::of(&room(), small_camera(), 0.0, 0.6, 0.2);
    let want = view.truth();
    view.depth_m.iter_mut().for_each(|d| *d *= 0.8);
    let inner =
        |got: &[bool]| (0..want.len()).filter(|&i| got[i] != want[i] && !at_border(&want, 120, i)).count();
    assert!(inner(&view.gather()) > 50, "depth a fifth too short shows");
}

#[test]
fn truth_rays_over_a_low_box_do_not_clear_it() {
    if skipped() {
        return;
    }
    let mut view = View::of(
        &Scene::of(&[Block::new([2.51, -3.0, 0.0], [2.7, 3.0, 2.5])]),
        small_camera(),
        0.0,
        0.6,
        0.0,
    );
    let ahead = |x: f64| 60 * 120 + ((x + 3.0) / 0.05) as usize;
    assert!(view.gather()[ahead(1.0)], "nothing is recorded: the ray clears");
    // A level camera of 0.6 m looks down by atan(59.5 / 146): at 1.0 m it sees heights from 0.19 m up.
    view.top_m = Some(0.15);
    assert!(!view.gather()[ahead(1.0)], "all rays pass above the recorded 0.15 m");
    view.top_m = Some(0.35);
    assert!(view.gather()[ahead(1.0)], "some ray passes under 0.35 m");
    assert!(view.disagreement()[0] <= 1);
}

#[test]
fn truth_hits_and_floor_points_decide_first() {
    if skipped() {
        return;
    }
    let mut view = View::of(&room(), tiny_camera(), 0.0, 0.6, 0.2);
    let seen = view.gather();
    let some = seen.iter().position(|s| *s).unwrap();
    let hidden = 118 * 120 + 118;
    assert!(!seen[hidden] && !seen[60 * 120 + 110], "behind the wall");
    let mut hits = vec![[0; 4]; 120 * 120];
    (hits[some], hits[hidden]) = ([1, 1, 2, 0], [0, 0, 1, 0]);
    let now = view.gather_with(&hits);
    assert!(!now[some], "a cell with hits is not seen through");
    assert!(!now[hidden], "the floor there is beyond the mark range");
    hits[hidden] = [0; 4];
    hits[60 * 120 + 110] = [0, 0, 1, 0];
    assert!(view.gather_with(&hits)[60 * 120 + 110], "a trusted floor point clears");
    view.config.min_hits = 2;
    assert!(view.gather_with(&hits)[some], "one hit of the two that are asked for");
}

#[test]
fn truth_untrusted_pixels_clear_nothing() {
    if skipped() {
        return;
    }
    let mut view = View::of(&room(), tiny_camera(), 0.0, 0.6, 0.2);
    view.reliability.iter_mut().for_each(|r| *r = 0.3);
    assert!(view.gather().iter().all(|seen| !seen), "tau itself is not trusted");
}

#[test]
fn edge_sizes() {
    if skipped() {
        return;
    }
    let mut view = View::of(&room(), tiny_camera(), 0.0, 0.6, 0.2);
    view.fragment(&vec![[0; 4]; 120 * 120]).refuses_nothing(GATHER);
    for side in [8, 9, 15, 17] {
        view.config.map_size_m = f64::from(side) * 0.05;
        view.window_from_camera.translation_m = DVec3::new(0.0, 0.2, 0.6);
        let [inner, ..] = view.disagreement();
        assert!(inner <= 1, "{side} cells: {inner}");
    }
    let one = CameraModel { width: 1, height: 1, cx: 0.0, cy: 0.0, ..tiny_camera() };
    let lone = View::of(&room(), one, 0.0, 0.6, 0.0);
    let (seen, truth) = (lone.gather(), lone.truth());
    let both = (0..seen.len()).filter(|&i| seen[i] && truth[i]).count();
    // The ray crosses 45 cells before the wall; the centres of those nearer than 0.6 m lie beside its pixel.
    assert!(both > 30, "{both}");
}

#[test]
fn poison() {
    if skipped() {
        return;
    }
    let mut view = View::of(&room(), tiny_camera(), 0.0, 0.6, 0.2);
    for nothing in [0.0, -1.0, f32::NEG_INFINITY, 1e-30] {
        view.depth_m.fill(nothing);
        assert!(view.gather().iter().all(|seen| !seen), "depth {nothing}");
    }
    for huge in [65.535, 1e30, f32::MAX] {
        view.depth_m.fill(huge);
        view.reliability.fill(1.0);
        let seen = view.gather().iter().filter(|seen| **seen).count();
        assert!(seen > 500, "a ray of {huge} m crosses all of its view: {seen}");
    }
    view.window_from_camera.translation_m = DVec3::splat(1e6);
    assert!(view.gather().iter().all(|seen| !seen), "a camera far away sees no cell");
}

#[test]
fn the_reference_itself() {
    let ray = Ray::new(DVec3::new(0.0, 0.0, 1.0), DVec3::new(2.0, 0.0, 0.0));
    let crosses = |x: f64, y: f64| ray.crosses(DVec2::new(x, y), 0.1, 0.1, 2.0);
    assert!(crosses(1.0, -0.05) && crosses(0.0, -0.05), "before its end");
    assert!(!crosses(1.85, -0.05), "under the band");
    assert!(!crosses(1.95, -0.05) && !crosses(2.5, -0.05), "behind its end");
    assert!(!crosses(1.0, 0.01) && !crosses(-1.0, -0.05), "beside and behind the camera");
}

#[test]
fn depths_to_a_pane_clear_as_far_as_those_to_a_wall() {
    if skipped() {
        return;
    }
    let scene = Scene::of(&[Block::new([2.31, -3.0, 0.0], [2.5, 3.0, 2.5])]);
    let wall = View::of(&scene, tiny_camera(), 0.3, 0.6, 0.3);
    let pane = View {
        depth_m: wall.depth_m.iter().map(|depth| -depth).collect(),
        reliability: wall.reliability.clone(),
        ..View::of(&scene, tiny_camera(), 0.3, 0.6, 0.3)
    };
    let hits = vec![[0_u32; 4]; wall.side() * wall.side()];
    let area = Invocations::area(wall.side() as u32, wall.side() as u32);
    let around = wall.around();
    let seen = |view: &View| {
        let (params, cells) = (view.params(), view.side() * view.side());
        let out = Fragment::new()
            .params("see_through_gather_params", &params)
            .input("ground_now", &stated_now(0.0))
            .input("depth_m", &view.depth_m)
            .input("reliability", &view.reliability)
            .input("cells", &vec![[0_u32; 4]; cells])
            .input("cell_hits", &hits)
            .input("around_far_m", &around)
            .changed("seen_through", &vec![0_u32; cells])
            .run(GATHER, area);
        out.words("seen_through").to_vec()
    };
    assert!(seen(&wall).iter().sum::<u32>() > 300);
    assert_eq!(seen(&pane), seen(&wall));
}
