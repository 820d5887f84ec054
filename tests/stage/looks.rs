//! The share of the pixels that look through a cell at the heights that count, and neighbours that were occupied.

use glam::{DVec2, DVec3};
use limpid::gpu::Invocations;
use limpid::sensor::CameraModel;
use limpid::stage::camera::see_through::GATHER_SHARES;
use limpid::stage::ground::stated_now;

use crate::reference::evidence::{Frame, layers, share_through};
use crate::stage::see_through::{View, room};
use crate::support::camera_job::tiny_camera;
use crate::support::gpu::{Fragment, skipped};
use crate::support::scene::{Block, Scene, small_camera};

/// Two samples of a pixel, or none, at either end of the vertical, and those of one row that lies on an edge in f32.
const SHARE: f64 = 0.06;

/// Share of the cells in which more may differ: a pixel of many that lies just before or behind the far edge.
const DISAGREEMENT: f64 = 0.01;

const BESIDE: u32 = 0x1_0000;
const ONE: f64 = 65535.0;

/// Hits of a cell and its record.
#[derive(Clone, Copy, Default)]
struct Cell {
    /// Lowest and highest hit of the frame above the ground, metres.
    hits_m: Option<[f64; 2]>,
    /// Highest hit recorded.
    top_m: Option<f64>,
    support: f32,
    occupied: bool,
}

fn steps(height_m: f64) -> u32 {
    ((height_m - 0.1) * 65536.0).round() as u32 + 2
}

fn fragment(view: &View, cells: &[Cell]) -> Fragment {
    let hits: Vec<[u32; 4]> = cells
        .iter()
        .map(|cell| cell.hits_m.map_or([0; 4], |[low, high]| [3, 3, steps(high), !steps(low)]))
        .collect();
    let records: Vec<[u32; 4]> = cells
        .iter()
        .map(|cell| [cell.support.to_bits(), 2 * u32::from(cell.occupied), 0, cell.top_m.map_or(0, steps)])
        .collect();
    Fragment::new()
        .params("see_through_gather_params", &view.params())
        .input("ground_now", &stated_now(0.0))
        .input("depth_m", &view.depth_m)
        .input("reliability", &view.reliability)
        .input("cells", &records)
        .input("cell_hits", &hits)
        .changed("seen_through", &vec![0_u32; cells.len()])
}

fn words(view: &View, cells: &[Cell]) -> Vec<u32> {
    let side = view.side() as u32;
    fragment(view, cells).run(GATHER_SHARES, Invocations::area(side, side)).words("seen_through").to_vec()
}

fn shares(view: &View, cells: &[Cell]) -> Vec<f64> {
    words(view, cells).iter().map(|word| f64::from(word & 0xffff) / ONE).collect()
}

fn centre(view: &View, cell: usize) -> DVec2 {
    let [x, y] = [cell % view.side(), cell / view.side()].map(|at| at as f64 + 0.5);
    DVec2::new(x, y) * view.config.resolution_m
}

fn truth(view: &View, cell: usize, heights_m: [f64; 2]) -> f64 {
    let View { camera, window_from_camera, depth_m, reliability, config, .. } = view;
    let frame =
        Frame { camera, window_from_camera: *window_from_camera, depth_m, reliability, tau: config.tau };
    let at = centre(view, cell);
    let in_range = (at - window_from_camera.translation_m.truncate()).length() <= config.mark_range_m;
    if in_range { share_through(frame, at, config.resolution_m, heights_m).unwrap_or(0.0) } else { 0.0 }
}

/// Of every third cell those whose share differs from the truth by more than [`SHARE`], and those whose share is above 0: the truth of a
/// cell takes a processor longer than all shares take the pass.
fn compare(view: &View, cells: &[Cell], heights_m: impl Fn(&Cell) -> [f64; 2]) -> (usize, usize) {
    let got = shares(view, cells);
    let looked_at = (0..cells.len()).step_by(3);
    let both = looked_at.map(|cell| (got[cell], truth(view, cell, heights_m(&cells[cell]))));
    both.fold((0, 0), |(differ, some), (got, want)| {
        (differ + usize::from((got - want).abs() > SHARE), some + usize::from(want > 0.0))
    })
}

#[test]
fn truth_of_a_walk_up_every_vertical() {
    if skipped() {
        return;
    }
    let (mut differ, mut seen) = (0, 0);
    for (camera, yaw, height_m, pitch) in
        [(tiny_camera(), 0.0, 0.6, 0.2), (tiny_camera(), 2.4, 1.4, 0.7), (small_camera(), -0.3, 0.3, 0.0)]
    {
        let view = View::of(&room(), camera, yaw, height_m, pitch);
        let all = |cell: Cell| vec![cell; view.side() * view.side()];
        let hit = Cell { hits_m: Some([0.25, 0.5]), top_m: Some(1.9), ..Cell::default() };
        let kept = Cell { top_m: Some(0.46), ..Cell::default() };
        for (cell, heights_m) in
            [(Cell::default(), [0.1, 2.0]), (hit, layers(0.25, 0.5)), (kept, layers(0.1, 0.46))]
        {
            let (wrong, some) = compare(&view, &all(cell), |_| heights_m);
            (differ, seen) = (differ + wrong, seen + some);
        }
    }
    assert!(seen > 1000, "{seen}");
    assert!(differ as f64 <= DISAGREEMENT * seen as f64, "{differ} of {seen}");
}

#[test]
fn control_the_truth_turns_red() {
    if skipped() {
        return;
    }
    let mut view = View::of(&room(), tiny_camera(), 0.0, 0.6, 0.2);
    let cells = vec![Cell::default(); view.side() * view.side()];
    let (differ, _) = compare(&view, &cells, |_| [0.1, 0.3]);
    assert!(differ > 100, "other heights show: {differ}");
    let want = shares(&view, &cells);
    view.depth_m.iter_mut().for_each(|depth| *depth *= 0.8);
    let differ = shares(&view, &cells).iter().zip(&want).filter(|(a, b)| (**a - **b).abs() > SHARE).count();
    assert!(differ > 300, "depth a fifth too short shows: {differ}");
}

/// A wall 2.5 m ahead of a level camera 0.6 m above the ground, whose rays cross all heights of what stands before it.
fn wall() -> View {
    View::of(&Scene::of(&[Block::new([2.51, -3.0, 0.0], [2.7, 3.0, 2.5])]), small_camera(), 0.0, 0.6, 0.0)
}

/// The cell of the window at `x` metres ahead of its middle.
fn ahead(x: f64) -> usize {
    60 * 120 + ((x + 3.0) / 0.05) as usize
}

#[test]
fn truth_only_the_heights_that_were_hit_count() {
    if skipped() {
        return;
    }
    // A plate from 0.3 to 0.6 m high, 1 m ahead, before the wall: two of the layers are hit, what passes above and below does not count.
    let plate = Block::new([1.01, -0.5, 0.3], [1.02, 0.5, 0.6]);
    let far = Block::new([2.51, -3.0, 0.0], [2.7, 3.0, 2.5]);
    let view = View::of(&Scene::of(&[plate, far]), small_camera(), 0.0, 0.6, 0.0);
    let share = |cell: Cell| {
        let mut cells = vec![Cell::default(); 120 * 120];
        cells[ahead(1.03)] = cell;
        shares(&view, &cells)[ahead(1.03)]
    };
    let hit = |low, high| share(Cell { hits_m: Some([low, high]), ..Cell::default() });
    assert!(hit(0.31, 0.59) < SHARE, "{}", hit(0.31, 0.59));
    assert!(hit(0.61, 0.75) > 1.0 - SHARE, "above the plate: {}", hit(0.61, 0.75));
    assert!((0.3..0.8).contains(&hit(0.31, 0.79)), "both: {}", hit(0.31, 0.79));
    let recorded = |top| share(Cell { top_m: Some(top), ..Cell::default() });
    assert!(recorded(0.59) > 0.2 && recorded(0.59) < 0.6, "from the band's lower edge: {}", recorded(0.59));
    assert!(share(Cell::default()) > recorded(0.59), "the whole band where no hit is recorded");
}

#[test]
fn truth_untrusted_pixels_look_but_do_not_pass() {
    if skipped() {
        return;
    }
    let mut view = wall();
    let cells = vec![Cell::default(); 120 * 120];
    assert!(shares(&view, &cells)[ahead(1.0)] > 1.0 - SHARE);
    for (pixel, weight) in view.reliability.iter_mut().enumerate() {
        *weight = if pixel / 160 % 2 == 0 { 0.3 } else { 0.31 };
    }
    let half = shares(&view, &cells)[ahead(1.0)];
    assert!((half - 0.5).abs() < SHARE, "tau itself is not trusted: {half}");
    view.reliability.fill(f32::NAN);
    assert!(words(&view, &cells).iter().all(|word| *word == 0), "NaN is no trust");
}

#[test]
fn truth_a_ray_that_ends_below_the_ground_clears_nothing_beyond_its_crossing() {
    if skipped() {
        return;
    }
    // A mirror image: the rays that meet the floor are twice as long.
    let mut view = View::of(&Scene::default(), small_camera(), 0.0, 0.6, 0.7);
    let floor = view.depth_m.clone();
    view.depth_m.iter_mut().for_each(|depth| *depth *= 2.0);
    let cells = vec![Cell::default(); 120 * 120];
    let mirrored = shares(&view, &cells);
    let View { camera, window_from_camera, .. } = &view;
    // Where the highest ray of a column comes down to the band's lower edge: no ray crosses the band beyond.
    let top = (0..camera.width as usize).find(|pixel| floor[*pixel] > 0.0).unwrap();
    let [x, y] = camera.ray(top as f64, 0.0).unwrap();
    let end = window_from_camera.transform_point(DVec3::new(x, y, 1.0) * f64::from(floor[top]));
    let eye = window_from_camera.translation_m;
    let crossing_m = (end - eye).truncate().length() * (eye.z - 0.1) / eye.z;
    let range = |cell: &usize| (centre(&view, *cell) - eye.truncate()).length();
    let cleared = |far: bool| {
        let beyond = |cell: &usize| (range(cell) > 1.3 * crossing_m) == far;
        (0..mirrored.len()).filter(beyond).filter(|cell| mirrored[*cell] > 0.0).count()
    };
    assert!(crossing_m < 2.5, "{crossing_m}");
    assert_eq!(cleared(true), 0);
    assert!(cleared(false) > 100, "before it is clear: {}", cleared(false));
}

#[test]
fn truth_beside_what_was_occupied_before_the_frame() {
    if skipped() {
        return;
    }
    let (view, mut cells) = (wall(), vec![Cell::default(); 120 * 120]);
    let at = |x: usize, y: usize| y * 120 + x;
    let strong = Cell { support: 1.75, occupied: true, ..Cell::default() };
    cells[at(90, 60)] = strong;
    cells[at(100, 60)] = Cell { support: 1.74, ..strong };
    cells[at(110, 60)] = Cell { occupied: false, ..strong };
    let hit = Cell { hits_m: Some([0.2, 0.4]), ..Cell::default() };
    let around = |x: usize| [(x - 1, 59), (x, 59), (x + 1, 61), (x + 1, 60)].map(|(x, y)| at(x, y));
    for cell in [90, 100, 110].into_iter().flat_map(around) {
        cells[cell] = hit;
    }
    (cells[at(92, 60)], cells[at(91, 58)]) = (hit, hit);
    // Without hits what is left of the evidence may be enough.
    (cells[at(89, 60)], cells[at(89, 61)]) =
        (Cell { support: 0.44, ..cells[0] }, Cell { support: 0.43, ..cells[0] });
    let got = words(&view, &cells);
    let beside: Vec<usize> = (0..got.len()).filter(|cell| got[*cell] & BESIDE != 0).collect();
    let mut want = around(90).to_vec();
    want.push(at(89, 60));
    want.sort_unstable();
    assert_eq!(beside, want);
}

#[test]
fn edge_sizes() {
    if skipped() {
        return;
    }
    let mut view = View::of(&room(), tiny_camera(), 0.0, 0.6, 0.2);
    fragment(&view, &vec![Cell::default(); 120 * 120]).refuses_nothing(GATHER_SHARES);
    for side in [8, 9, 15, 17] {
        view.config.map_size_m = f64::from(side) * 0.05;
        view.window_from_camera.translation_m = DVec3::new(-0.3, 0.2, 0.6);
        let (differ, _) = compare(&view, &vec![Cell::default(); view.side() * view.side()], |_| [0.1, 2.0]);
        assert!(differ <= 1, "{side} cells: {differ}");
    }
    let one = CameraModel { width: 1, height: 1, cx: 0.0, cy: 0.0, ..tiny_camera() };
    let lone = View::of(&room(), one, 0.0, 0.6, 0.0);
    let seen = shares(&lone, &vec![Cell::default(); 120 * 120]);
    assert!(seen.iter().filter(|share| **share == 1.0).count() > 30, "one pixel, which looks through");
}

#[test]
fn poison() {
    if skipped() {
        return;
    }
    let mut view = wall();
    let mut cells = vec![Cell::default(); 120 * 120];
    for nothing in [0.0, 1e-30, f32::NAN] {
        view.depth_m.fill(nothing);
        assert!(words(&view, &cells).iter().all(|word| *word == 0), "depth {nothing}");
    }
    view.depth_m.fill(f32::MAX);
    assert!(words(&view, &cells).iter().all(|word| *word <= 65535), "no share above 1");
    cells.fill(Cell { hits_m: Some([0.1, 60.0]), top_m: Some(60.0), support: f32::NAN, occupied: true });
    assert!(words(&view, &cells).iter().all(|word| *word <= 65535), "NaN is not enough evidence");
    view.window_from_camera.translation_m = DVec3::splat(1e6);
    assert!(words(&view, &cells).iter().all(|word| *word == 0), "a camera far away sees no cell");
}
