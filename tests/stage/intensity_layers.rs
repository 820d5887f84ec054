//! Points into layers.

use glam::{Vec2, Vec4};
use limpid::gpu::{Invocations, ShaderSource};
use limpid::sensor::Point;
use limpid::stage::ground::stated_now;
use limpid::stage::lidar::intensity_layers::{
    INTENSITY_LAYERS, INTENSITY_LAYERS_OF_BUFFER, IntensityLayersParams, POINT_ROW,
};

use crate::reference::intensity_layers::{Layer, layer_sums};
use crate::support::compare::{EXACT, assert_close, compare};
use crate::support::gpu::{Fragment, Outputs, skipped};
use crate::support::random::Random;
use crate::support::scan::point;

const SIDE: usize = 12;
const CELL_M: f64 = 0.25;
const AT_M: f64 = 1.5;
const RINGS: [u16; 2] = [3, 2];
const SECTORS: usize = 720;

/// Three tall layers, from 1 m below the lidar to 1 m above it.
pub(super) fn params(points: usize) -> IntensityLayersParams {
    let mut heights = [Vec4::splat(1.0); 5];
    heights[0] = Vec4::new(-1.0, 0.0, 0.5, 1.0);
    IntensityLayersParams {
        window_from_lidar_x: Vec4::new(1.0, 0.0, 0.0, AT_M as f32),
        window_from_lidar_y: Vec4::new(0.0, 1.0, 0.0, AT_M as f32),
        window_from_lidar_z: Vec4::Z,
        turn_axis: Vec4::X,
        turn_way: Vec4::ZERO,
        heights,
        lidar: Vec2::splat(AT_M as f32),
        first_s: 0.0,
        points: points as u32,
        side: SIDE as u32,
        resolution_m: CELL_M as f32,
        tall: 3,
        per_unit: 1.0 / 255.0,
        plane_ring: RINGS[0].into(),
        below_ring: RINGS[1].into(),
        below_m: -0.15,
        half_thickness_m: 0.05,
        clear_steps: 3000,
        standing: 0,
        floor_m: 0.0,
        ground_band_m: 0.1,
    }
}

fn run(params: &IntensityLayersParams, points: &[Point], constants: &[(&'static str, bool)]) -> Outputs {
    let bytes: Vec<u32> =
        bytemuck::cast_slice::<Point, u8>(points).chunks_exact(4).map(bytemuck::pod_read_unaligned).collect();
    run_on(params, constants, Fragment::new().input("points", &bytes), INTENSITY_LAYERS_OF_BUFFER)
}

fn run_on(
    params: &IntensityLayersParams,
    constants: &[(&'static str, bool)],
    points: Fragment,
    pass: ShaderSource,
) -> Outputs {
    points
        .params("intensity_layers_params", params)
        .input("ground_now", &stated_now(1.0))
        .changed("layer_sums", &vec![0_u32; SIDE * SIDE * 5 * 2])
        .changed("sector_range", &[0_u32; SECTORS * 2])
        .constants(constants)
        .run(pass, Invocations::line(params.points))
}

/// Points on a lattice that avoids the borders of cells and layers, some of them outside of the map.
fn random_points(random: &mut Random, count: usize) -> Vec<Point> {
    (0..count)
        .map(|_| {
            let mut place = |cells: u64| f64::from(random.below(cells)) * CELL_M / 4.0 + 0.03;
            let at = [place(64) - 2.0, place(64) - 2.0, place(40) - 1.28];
            let intensity = f64::from(random.below(300));
            Point { ring: random.below(5) as u16, ..point(at, intensity) }
        })
        .collect()
}

fn twin_layers() -> [Layer; 5] {
    [
        Layer::Heights(-1.0, 0.0, false),
        Layer::Heights(0.0, 0.5, false),
        Layer::Heights(0.5, 1.0, true),
        Layer::Ring(RINGS[0]),
        Layer::Ring(RINGS[1]),
    ]
}

fn compare_with_twin(points: &[Point]) {
    let out = run(&params(points.len()), points, &[("ringed", true)]);
    let want = layer_sums(points, SIDE, CELL_M, AT_M, 255.0, &twin_layers());
    let want: Vec<u32> = want.into_iter().flatten().collect();
    assert_close("layer_sums", out.words("layer_sums"), &want, EXACT);
    // The control: one point fewer shows.
    let fewer = layer_sums(&points[1..], SIDE, CELL_M, AT_M, 255.0, &twin_layers());
    let fewer: Vec<u32> = fewer.into_iter().flatten().collect();
    assert!(fewer == want || compare("sums", out.words("layer_sums"), &fewer, EXACT).is_err());
}

#[test]
fn twin_at_edge_sizes() {
    if skipped() {
        return;
    }
    let mut random = Random(5);
    for count in [1, 63, 64, 65, 700] {
        compare_with_twin(&random_points(&mut random, count));
    }
}

#[test]
fn points_in_a_texture_give_what_points_in_a_buffer_give() {
    if skipped() {
        return;
    }
    // One row of texels holds 512 points.
    for count in [1, 511, 512, 513] {
        let points = random_points(&mut Random(count), count as usize);
        let (params, ringed) = (params(points.len()), [("ringed", true), ("clearing", true)]);
        let buffer = run(&params, &points, &ringed);
        let height = (2 * params.points).div_ceil(POINT_ROW);
        let texture = Fragment::new().texture("points", [POINT_ROW, height], bytemuck::cast_slice(&points));
        let texture = run_on(&params, &ringed, texture, INTENSITY_LAYERS);
        for name in ["layer_sums", "sector_range"] {
            assert_eq!(texture.words(name), buffer.words(name));
            assert!(count == 1 || texture.words(name).iter().any(|&word| word > 0));
        }
    }
}

#[test]
fn truth_bounds_slabs_and_reach() {
    if skipped() {
        return;
    }
    // On the bounds of the layers: -1 to the first, 0 to the second, 1 (the uppermost) to the last, above it nothing.
    let points: Vec<Point> = [-1.0, 0.0, 0.5, 1.0, 1.01, -1.01].map(|z| point([1.1, 0.1, z], 255.0)).to_vec();
    let out = run(&params(points.len()), &points, &[("ringed", false)]);
    let cell = 6 * SIDE + 10;
    let counts: Vec<u32> = (0..5).map(|layer| out.words("layer_sums")[2 * (5 * cell + layer) + 1]).collect();
    assert_eq!(counts, [1, 1, 2, 1, 0], "the plane z = 0 is a copy");
    // Of the beams in that direction the one at z = 1 stays inside the layers all the way; the others leave them earlier.
    let reached = out.words("sector_range").iter().max().copied();
    let range_m = 1.1_f64.hypot(0.1);
    assert!((f64::from(reached.unwrap()) / 1024.0 - range_m).abs() < 2e-3);
    let high = run(&params(1), &[point([1.1, 0.1, 2.0], 255.0)], &[("ringed", false)]);
    let reached = high.words("sector_range").iter().max().copied();
    assert!(
        (f64::from(reached.unwrap()) / 1024.0 - range_m / 2.0).abs() < 2e-3,
        "it left the layers half way"
    );
}

#[test]
fn truth_points_are_placed_at_their_own_times() {
    if skipped() {
        return;
    }
    // The lidar turns by a quarter and moves by 0.5 m in 0.1 s: a point seen ahead at the end lies to the left.
    let turning = IntensityLayersParams {
        turn_axis: Vec4::new(0.0, 0.0, 1.0, std::f32::consts::FRAC_PI_2),
        turn_way: Vec4::new(0.5, 0.0, 0.0, 10.0),
        ..params(2)
    };
    let ahead = point([1.1, 0.1, 0.2], 255.0);
    let points = [Point { time_s: 0.1, ..ahead }, Point { time_s: 0.0, ..ahead }];
    let out = run(&turning, &points, &[("deskewed", true)]);
    let filled = |x: f64, y: f64| {
        let cell = ((y + AT_M) / CELL_M) as usize * SIDE + ((x + AT_M) / CELL_M) as usize;
        out.words("layer_sums")[2 * (5 * cell + 1) + 1]
    };
    assert_eq!((filled(0.4, 1.1), filled(1.1, 0.1)), (1, 1));
    let still = run(&turning, &points, &[("deskewed", false)]);
    assert_eq!(still.words("layer_sums").iter().max(), Some(&(2 * 4080)), "both in one cell");
}

#[test]
fn truth_what_stands_counts_fully_and_the_floor_not_at_all() {
    if skipped() {
        return;
    }
    let heights = [-0.9, -0.41, -0.4, -0.39, 0.2];
    let points: Vec<Point> = heights.map(|z| point([1.1, 0.1, z], 3.0)).to_vec();
    let standing = IntensityLayersParams { standing: 1, floor_m: -0.4, ..params(points.len()) };
    let cell = 6 * SIDE + 10;
    let sums = |params: &IntensityLayersParams| {
        let out = run(params, &points, &[("ringed", false)]);
        [0, 1].map(|layer| [0, 1].map(|word| out.words("layer_sums")[2 * (5 * cell + layer) + word]))
    };
    assert_eq!(sums(&standing), [[4080, 4], [4080, 1]], "one of four in the lower layer stands");
    let faint = (3.0_f64 / 255.0 * 4080.0).round() as u32;
    assert_eq!(sums(&IntensityLayersParams { standing: 0, ..standing }), [[4 * faint, 4], [faint, 1]]);
}

#[test]
fn poison_is_left_out() {
    if skipped() {
        return;
    }
    let ahead = point([1.1, 0.1, 0.2], 255.0);
    let mut points = Vec::new();
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        points.push(Point { x_m: bad, ..ahead });
        points.push(Point { y_m: bad, ..ahead });
        points.push(Point { z_m: bad, ..ahead });
        points.push(Point { intensity: bad, ..ahead });
        points.push(Point { time_s: bad, ..ahead });
    }
    let out = run(&params(points.len()), &points, &[("ringed", true)]);
    assert!(out.words("layer_sums").iter().chain(out.words("sector_range")).all(|&word| word == 0));
    points.extend([3.0e38, -3.0e38].map(|huge| Point { x_m: huge, ..ahead }));
    points.extend([3.0e38, -3.0e38].map(|huge| Point { intensity: huge, ..ahead }));
    let out = run(&params(points.len()), &points, &[("ringed", true)]);
    assert_eq!(out.words("layer_sums").iter().sum::<u32>(), 4080 + 2, "clamped to full scale and to 0");
    Fragment::new()
        .params("intensity_layers_params", &params(1))
        .input("ground_now", &stated_now(1.0))
        .input("points", &[0_u32; 8])
        .changed("layer_sums", &[0_u32; 2])
        .changed("sector_range", &[0_u32; 2])
        .refuses_nothing(INTENSITY_LAYERS_OF_BUFFER);
}
