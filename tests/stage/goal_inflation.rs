//! The kernel, and its spread.

use glam::DVec2;
use limpid::config::{Config, InflationKernel};
use limpid::gpu::Invocations;
use limpid::map::Verdict;
use limpid::stage::map::goal_inflation::{
    GOAL_INFLATION_OF_CAMERAS, GOAL_INFLATION_OF_LIDARS, GoalInflationParams, kernel, params,
};

use crate::reference::goal_inflation::{inflate, reaches};
use crate::support::compare::{EXACT, assert_close, compare};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

const KERNELS: [InflationKernel; 3] =
    [InflationKernel::Adaptive, InflationKernel::Symmetric, InflationKernel::Uniform];

fn config(inflation_kernel: InflationKernel) -> Config {
    Config { inflation_kernel, inflation_length_m: 0.6, inscribed_radius_m: 0.15, ..Config::default() }
}

fn towards(theta: f64) -> Option<DVec2> {
    Some(DVec2::from_angle(theta))
}

const ORIGIN_SLOT: [u32; 2] = [4, 17];

/// Row, cost and the strength that the solidity layer keeps.
type Cell = (u32, u8, u32);

/// Sum of strengths and whether within the inscribed radius, cell by cell; in a map with `lidars`, or without.
fn spread_cells(config: &Config, theta: f64, cells: &[Cell], lidars: bool) -> Vec<u32> {
    let side = cells.len().isqrt();
    let kernel = kernel(config, towards(theta));
    let origin_slot = ORIGIN_SLOT.map(|slot| slot % side as u32);
    let verdicts: Vec<u32> =
        cells.iter().map(|&(row, cost, _)| Verdict::pack(cost, row, Some(3), 77).0).collect();
    let mut solid = vec![[u32::MAX; 4]; side * side];
    for (cell, &(.., steps)) in cells.iter().enumerate() {
        let [x, y] = [cell % side + origin_slot[0] as usize, cell / side + origin_slot[1] as usize];
        solid[y % side * side + x % side] = [steps << 20 | 0xf_ff02, 1, 0, 0];
    }
    let mut fragment = Fragment::new()
        .params("goal_inflation_params", &params(side as u32, &kernel, origin_slot))
        .input("verdicts", &verdicts)
        .input("kernel_taps", &kernel.packed())
        .changed("inflation", &vec![0_u32; side * side]);
    if lidars {
        fragment = fragment.input("solid_cells", &solid);
    }
    let pass = if lidars { GOAL_INFLATION_OF_LIDARS } else { GOAL_INFLATION_OF_CAMERAS };
    let out = fragment.run(pass, Invocations::area(side as u32, side as u32));
    out.words("inflation").iter().flat_map(|word| [word & (u32::MAX >> 1), word >> 31]).collect()
}

/// The same of cells that a lidar finds solid where they have any strength, else free.
fn spread(config: &Config, theta: f64, strength: &[u32]) -> Vec<u32> {
    let cell = |&steps: &u32| if steps > 0 { (2, 254, steps) } else { (8, 0, 0) };
    spread_cells(config, theta, &strength.iter().map(cell).collect::<Vec<_>>(), true)
}

#[test]
fn twin_for_all_kernels_and_directions() {
    if skipped() {
        return;
    }
    let side = 19;
    let mut random = Random(8);
    let strength: Vec<u32> =
        (0..side * side).map(|_| if random.chance(0.05) { random.below(4080) + 1 } else { 0 }).collect();
    for (number, inflation_kernel) in KERNELS.into_iter().enumerate() {
        let config = config(inflation_kernel);
        for degrees in [0.0, 37.0 + number as f64, 90.0, -90.0, 180.0, 225.0] {
            let theta = f64::to_radians(degrees);
            let got = spread(&config, theta, &strength);
            let want: Vec<u32> = inflate(&config, theta, side, &strength).into_iter().flatten().collect();
            assert_close(&format!("{inflation_kernel:?} at {degrees}"), &got, &want, EXACT);
            let other: Vec<u32> =
                inflate(&config, theta + 1.2, side, &strength).into_iter().flatten().collect();
            let differs = compare("another direction", &got, &other, EXACT).is_err();
            assert_eq!(differs, inflation_kernel != InflationKernel::Uniform);
        }
    }
}

#[test]
fn edge_sizes() {
    if skipped() {
        return;
    }
    let config = config(InflationKernel::Adaptive);
    for side in [1, 7, 8, 9] {
        let strength = vec![7; side * side];
        let want: Vec<u32> = inflate(&config, 0.3, side, &strength).into_iter().flatten().collect();
        assert_close("spread", &spread(&config, 0.3, &strength), &want, EXACT);
        let nothing = spread(&config, 0.3, &vec![0; side * side]);
        assert!(nothing.iter().all(|&word| word == 0));
    }
    for lidars in [true, false] {
        let nothing =
            GoalInflationParams { side: 1, taps: 0, inscribed: 0, origin_slot_x: 0, origin_slot_y: 0 };
        let mut fragment = Fragment::new()
            .params("goal_inflation_params", &nothing)
            .input("verdicts", &[0_u32])
            .input("kernel_taps", &[0_u32])
            .changed("inflation", &[0_u32]);
        if lidars {
            fragment = fragment.input("solid_cells", &[[0_u32; 4]]);
        }
        fragment.refuses_nothing(if lidars { GOAL_INFLATION_OF_LIDARS } else { GOAL_INFLATION_OF_CAMERAS });
    }
}

#[test]
fn truth_the_line_is_as_thick_at_45_degrees_as_along_an_axis() {
    let symmetric = Config { inflation_length_m: 2.0, ..config(InflationKernel::Symmetric) };
    for degrees in [0.0_f64, 45.0, 90.0, 30.0] {
        let line = kernel(&symmetric, towards(degrees.to_radians()));
        let along = DVec2::from_angle(degrees.to_radians());
        let widest = line.taps.iter().map(|&[x, y]| DVec2::new(x.into(), y.into()).perp_dot(along).abs());
        let widest = widest.fold(0.0, f64::max);
        // The disc of 0.2 m is two cells, the line's half-width one and a half.
        assert!((1.2..=2.0).contains(&widest), "{degrees}: {widest}");
    }
    // Paper form at 45 degrees: shifting both indices thickens nothing; here three diagonals are covered.
    let line = kernel(&symmetric, towards(std::f64::consts::FRAC_PI_4));
    for tap in [[10, 10], [10, 9], [9, 10], [10, 11], [-10, -9]] {
        assert!(line.taps.contains(&tap), "{tap:?}");
    }
}

#[test]
fn truth_adaptive_reaches_back_from_the_goal_and_never_less_than_the_robot() {
    let ahead = kernel(&config(InflationKernel::Adaptive), towards(0.0));
    assert!(ahead.taps.contains(&[-6, 0]) && ahead.taps.contains(&[-6, 1]) && !ahead.taps.contains(&[-6, 2]));
    assert!(!ahead.taps.contains(&[3, 0]) && ahead.taps.contains(&[2, 0]), "only the disc ahead");
    for theta in [0.0, 1.0, 2.0, 3.0, -1.5] {
        let wide = Config {
            inscribed_radius_m: 0.45,
            inflation_radius_m: 0.55,
            ..config(InflationKernel::Adaptive)
        };
        let taps = kernel(&wide, towards(theta)).taps;
        let round = (-4..=4).flat_map(|y| (-4..=4).map(move |x| [x, y]));
        for [x, y] in round.filter(|[x, y]| x * x + y * y <= 20) {
            assert!(taps.contains(&[x, y]), "{x} {y}");
            assert!(reaches(&wide, theta, x.into(), y.into()).1);
        }
    }
    let at_goal = kernel(&config(InflationKernel::Adaptive), None);
    assert!(at_goal.taps.iter().all(|[x, y]| x * x + y * y <= 4) && at_goal.taps.contains(&[0, 0]));
    let square = kernel(&config(InflationKernel::Uniform), None);
    assert_eq!(square.taps.len(), 13 * 13);
}

fn lethal_and_other_cells(count: usize, random: &mut Random) -> Vec<Cell> {
    let mut cell = || match random.below(40) {
        0 => (2, 254, random.below(4080) + 1),
        1 => (3, 254, random.below(4080) + 1),
        2 => ([1, 4, 6][random.below(3) as usize], 254, random.below(4080)),
        3 => (7, 50, random.below(4080)),
        4 => (11, 255, random.below(4080)),
        _ => (8, 0, 0),
    };
    (0..count).map(|_| cell()).collect()
}

#[test]
fn lethal_verdicts_are_spread_fully_where_no_lidar_says_how_much() {
    if skipped() {
        return;
    }
    let side = 19;
    let (config, mut random) = (config(InflationKernel::Adaptive), Random(9));
    let cells = lethal_and_other_cells(side * side, &mut random);
    let spread = |lidars| spread_cells(&config, 0.6, &cells, lidars);
    let strength = |lidars: bool| -> Vec<u32> {
        let of = |&(row, cost, steps): &Cell| match (cost, row) {
            (254, 2 | 3) if lidars => steps,
            (254, _) => 4080,
            _ => 0,
        };
        cells.iter().map(of).collect()
    };
    for lidars in [true, false] {
        let want: Vec<u32> = inflate(&config, 0.6, side, &strength(lidars)).into_iter().flatten().collect();
        assert_close("spread", &spread(lidars), &want, EXACT);
    }
    assert!(compare("the layers differ", &spread(true), &spread(false), EXACT).is_err());
}
