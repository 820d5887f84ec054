//! Classes of cells, and glass remembered.

use glam::{Vec2, Vec4};
use limpid::gpu::Invocations;
use limpid::stage::ground::stated_now;
use limpid::stage::lidar::intensity_classes::{INTENSITY_CLASSES, IntensityClassesParams, layer_params};

use crate::reference::intensity_classes::{Cell, Limits, classify};
use crate::support::compare::{EXACT, Tolerance, assert_close};
use crate::support::gpu::{Fragment, Outputs, skipped};
use crate::support::random::Random;

const SECTORS: usize = 720;
const STEP: Tolerance = Tolerance { absolute: 1.0, reason: "f32 against f64 at the half of a step" };
const LIMITS: Limits = Limits { gamma: 0.5, transparent: 0.1, min_returns: 2 };

pub(super) fn params(side: usize) -> IntensityClassesParams {
    let mut heights = [Vec4::splat(0.5); 5];
    heights[0] = Vec4::new(-0.5, 0.0, 0.5, 0.5);
    IntensityClassesParams {
        heights,
        lidar: Vec2::splat(0.05 * side as f32),
        side: side as u32,
        tall: 2,
        origin_slot_x: 0,
        origin_slot_y: 0,
        resolution_m: 0.1,
        gamma: LIMITS.gamma as f32,
        transparent_threshold: LIMITS.transparent as f32,
        solid_value: 1.0,
        keep_share: 1.0,
        min_returns: LIMITS.min_returns,
        rays_per_rad: 286.0,
        rings_per_rad: 28.6,
        elevation_low: -0.26,
        elevation_high: 0.26,
        shift_x: 0,
        shift_y: 0,
        forget: 0,
        standing: 0,
    }
}

/// Remembered steps as the pass keeps them.
const fn in_memory(steps: u32) -> u32 {
    steps << 20
}

/// What the layer holds before: glass that this lidar saw. Such a cell takes over the word of any scan, also of one that says
/// nothing of it by itself.
const OWN_GLASS: [u32; 4] = [4, 1, 0, 1 << 24];

/// (sum, count) of the four layers of each cell; every beam reaches `reach_m`.
fn run(
    params: &IntensityClassesParams,
    layers: &[[[u32; 2]; 4]],
    reach_m: f64,
    remembered: &[u32],
    constants: &[(&'static str, bool)],
) -> Outputs {
    let cells = (params.side * params.side) as usize;
    let sums: Vec<[u32; 2]> = layers.iter().flatten().copied().collect();
    Fragment::new()
        .params("intensity_classes_params", params)
        .input("ground_now", &stated_now(0.5))
        .params("solid_cells_params", &layer_params(20, 0, 0.5))
        .input("layer_sums", &sums)
        .input("sector_range", &vec![(reach_m * 1024.0) as u32; 2 * SECTORS])
        .changed("remembered", remembered)
        .changed("solid_cells", &vec![OWN_GLASS; cells])
        .output("obstacle_value", cells)
        .output("layer_values", 4 * cells)
        .constants(constants)
        .run(INTENSITY_CLASSES, Invocations::area(params.side, params.side))
}

/// As [`run`] where nothing was seen before.
fn run_anew(params: &IntensityClassesParams, layers: &[[[u32; 2]; 4]]) -> Outputs {
    let cells = layers.len();
    let sums: Vec<[u32; 2]> = layers.iter().flatten().copied().collect();
    Fragment::new()
        .params("intensity_classes_params", params)
        .input("ground_now", &stated_now(0.5))
        .params("solid_cells_params", &layer_params(20, 0, 0.5))
        .input("layer_sums", &sums)
        .input("sector_range", &[0_u32; 2 * SECTORS])
        .changed("remembered", &vec![0_u32; cells])
        .changed("solid_cells", &vec![[0_u32; 4]; cells])
        .output("obstacle_value", cells)
        .output("layer_values", 4 * cells)
        .run(INTENSITY_CLASSES, Invocations::area(params.side, params.side))
}

/// The words of the cells, by their places in the window.
fn words(out: &Outputs, params: &IntensityClassesParams) -> Vec<u32> {
    let (side, layer) = (params.side, out.words("solid_cells"));
    let slot = |cell: u32| {
        let [x, y] = [cell % side + params.origin_slot_x, cell / side + params.origin_slot_y];
        (y % side * side + x % side) as usize
    };
    (0..side * side).map(|cell| layer[4 * slot(cell)]).collect()
}

fn compare_with_twin(side: usize, seed: u64) {
    let mut random = Random(seed);
    let mut layer = || {
        let count = random.below(6);
        // Values away from the thresholds, which are multiples of 408 steps a return.
        let sum = (0..count).map(|_| random.below(9) * 408 + 100 + random.below(200)).sum::<u32>();
        [sum, count]
    };
    let mut layers: Vec<[[u32; 2]; 4]> = (0..side * side).map(|_| std::array::from_fn(|_| layer())).collect();
    layers.iter_mut().skip(1).step_by(7).for_each(|layers| *layers = [NONE; 4]);
    let remembered: Vec<u32> =
        (0..side * side).map(|_| if random.chance(0.1) { random.below(4080) } else { 0 }).collect();
    let params = params(side);
    let out = run(
        &params,
        &layers,
        100.0,
        &remembered.iter().map(|&steps| in_memory(steps)).collect::<Vec<_>>(),
        &[],
    );
    let value = |[sum, count]: [u32; 2]| (f64::from(sum) / 4080.0 / f64::from(count.max(1)), count);
    let want: Vec<[u32; 3]> = layers
        .iter()
        .zip(&remembered)
        .map(|(layers, &remembered)| {
            let tall = layers[..2].iter().map(|&layer| value(layer)).collect();
            let (plane, below) = (value(layers[2]), value(layers[3]));
            classify(&Cell { tall, plane, below, crossed: true, remembered }, &LIMITS)
        })
        .collect();
    let column = |at: usize| want.iter().map(|cell| cell[at]).collect::<Vec<_>>();
    let words = words(&out, &params);
    let classes: Vec<u32> = words.iter().map(|word| word & 0xff).collect();
    assert_close("class", &classes, &column(0), EXACT);
    let strength: Vec<u32> = words.iter().map(|word| word >> 20).collect();
    assert_close("strength", &strength, &column(1), STEP);
    let glass: Vec<u32> = words.iter().map(|word| word >> 8 & 0xfff).collect();
    assert_close("glass", &glass, &column(2), STEP);
    let remembered: Vec<u32> = out.words("remembered").iter().map(|word| word >> 20).collect();
    assert_close("remembered", &remembered, &column(2), STEP);
    assert!(
        out.words("remembered").iter().all(|&word| word == in_memory(word >> 20)),
        "whole steps without decay"
    );
    if side > 8 {
        assert!(
            (0..5).filter(|class| *class != 0).all(|class| classes.contains(&class)),
            "all classes occur"
        );
    }
}

#[test]
fn truth_one_return_that_stands_makes_a_cell_solid() {
    if skipped() {
        return;
    }
    // Of a hundred returns one stands; none does; only the plane z = 0 has returns; there are fewer than are asked for.
    let layers = [
        [[4080, 100], NONE, [4080, 1], NONE],
        [[0, 100], NONE, NONE, NONE],
        [NONE, NONE, [4080, 2], NONE],
        [[4080, 1], NONE, NONE, NONE],
    ];
    for solid_value in [100.0, 1.0] {
        let standing = IntensityClassesParams { standing: 1, gamma: 0.0, solid_value, ..params(2) };
        let out = run_anew(&standing, &layers);
        let classes: Vec<u32> = words(&out, &standing).iter().map(|word| word & 0xff).collect();
        // SOLID, PASSABLE, SOLID, and what was kept of a cell that is not decided.
        assert_eq!(classes[..3], [2, 3, 2], "{solid_value}");
        assert_ne!(classes[3], 2, "{solid_value}");
    }
}

#[test]
fn twin_and_edge_sizes() {
    if skipped() {
        return;
    }
    for (side, seed) in [(1, 1), (7, 2), (8, 3), (9, 4), (17, 5)] {
        compare_with_twin(side, seed);
    }
}

const NONE: [u32; 2] = [0, 0];

#[test]
fn truth_free_unknown_undecided_glass_and_clearing() {
    if skipped() {
        return;
    }
    let class = |out: &Outputs| words(out, &params(1))[0] & 0xff;
    let one = |layers: [[u32; 2]; 4], reach_m: f64| class(&run(&params(1), &[layers], reach_m, &[0], &[]));
    assert_eq!(one([NONE; 4], 5.0), 1, "crossed");
    assert_eq!(one([NONE; 4], 0.05), 0, "the beam ended in it");
    assert_eq!(one([[4080, 1], NONE, NONE, NONE], 5.0), 0, "one return of two needed");
    assert_eq!(one([[8160, 2], NONE, NONE, NONE], 5.0), 2);
    assert_eq!(one([[1000, 2], NONE, NONE, NONE], 5.0), 3);
    let pane = [NONE, [2000, 2], [2000, 2], NONE];
    assert_eq!(one(pane, 5.0), 4, "the horizontal plane alone saw it");
    assert_eq!(one([NONE, [2000, 2], [2000, 2], [2000, 2]], 5.0), 3, "the plane below saw it too");
    assert_eq!(one([NONE, [8160, 2], [8160, 2], NONE], 5.0), 2, "head on so bright that it is solid");

    let keep = run(&params(1), &[[NONE; 4]], 5.0, &[in_memory(900)], &[]);
    assert_eq!((class(&keep), keep.words("remembered")[0]), (4, in_memory(900)));
    let cleared = run(&params(1), &[[NONE; 4]], 5.0, &[in_memory(900)], &[("clearing", true)]);
    assert_eq!((class(&cleared), cleared.words("remembered")[0]), (1, 0));
    let decayed = IntensityClassesParams { keep_share: 0.5, ..params(1) };
    let faded = run(&decayed, &[[NONE; 4]], 5.0, &[in_memory(900)], &[]);
    assert_eq!(faded.words("remembered")[0], in_memory(450));
    // A share of a step that is lost adds up over scans.
    let slow = IntensityClassesParams { keep_share: 1.0 - 1.0 / 4096.0, ..params(1) };
    let faded = run(&slow, &[[NONE; 4]], 5.0, &[in_memory(900)], &[]);
    assert_eq!(faded.words("remembered")[0], in_memory(900) - 900 * 256);
}

#[test]
fn truth_cells_that_enter_the_window_have_no_past() {
    if skipped() {
        return;
    }
    // Nine cells that all remember glass; the window moves by one cell along x, and by one back along y.
    let moved =
        IntensityClassesParams { shift_x: 1, shift_y: -1, origin_slot_x: 1, origin_slot_y: 2, ..params(3) };
    let out = run(&moved, &[[NONE; 4]; 9], 5.0, &[in_memory(900); 9], &[]);
    let glass: Vec<bool> = words(&out, &moved).iter().map(|word| word & 0xff == 4).collect();
    let (kept, new) = (true, false);
    assert_eq!(glass, [new, new, new, kept, kept, new, kept, kept, new]);
    // Window row 0 lies in the slots of row 2, column 2 in those of column 0.
    assert_eq!(out.words("remembered"), [0, 900, 900, 0, 900, 900, 0, 0, 0].map(in_memory));
    let forgotten = run(
        &IntensityClassesParams { forget: 1, ..params(3) },
        &[[NONE; 4]; 9],
        5.0,
        &[in_memory(900); 9],
        &[],
    );
    assert!(forgotten.words("remembered").iter().all(|&steps| steps == 0));
    let still = run(&params(3), &[[NONE; 4]; 9], 5.0, &[in_memory(900); 9], &[]);
    assert!(still.words("remembered").iter().all(|&steps| steps == in_memory(900)));
    let far = IntensityClassesParams { shift_x: i32::MIN, shift_y: i32::MAX, ..params(3) };
    assert!(
        run(&far, &[[NONE; 4]; 9], 5.0, &[in_memory(900); 9], &[])
            .words("remembered")
            .iter()
            .all(|&s| s == 0)
    );
}

#[test]
fn poison_stays_in_its_cell() {
    if skipped() {
        return;
    }
    let most = [u32::MAX, u32::MAX];
    let layers = [[most; 4], [[u32::MAX, 0]; 4], [NONE; 4], [[0, u32::MAX]; 4]];
    let out = run(&params(2), &layers, 1e5, &[u32::MAX, 0, 0, 0], &[]);
    assert!(out.floats("obstacle_value").iter().chain(&out.floats("layer_values")).all(|v| v.is_finite()));
    let words = words(&out, &params(2));
    assert!(words.iter().all(|word| word & 0xff <= 4));
    assert_eq!(words[2] & 0xff, 1);
}
