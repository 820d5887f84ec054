//! Places along arcs, and the costs under them.

use glam::Vec2;
use limpid::gpu::Invocations;
use limpid::stage::map::trajectory_cost::{ROLL_OUT, RollOutParams, SUM, SumParams};

use crate::reference::trajectory_cost::{cost, place};
use crate::support::compare::{EXACT, Tolerance, assert_close, compare};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

const START: [f64; 2] = [1.5, 2.0];
const HEADING: f64 = 0.7;
const STEP_S: f64 = 0.1;
const PLACE: Tolerance = Tolerance { absolute: 2e-5, reason: "f32 sines of ways of some metres" };

fn roll_out(velocities: &[[f64; 2]], places: usize) -> Vec<f32> {
    let params = RollOutParams {
        start: Vec2::new(START[0] as f32, START[1] as f32),
        heading: HEADING as f32,
        step_s: STEP_S as f32,
        candidates: velocities.len() as u32,
        places: places as u32,
    };
    let velocities: Vec<[f32; 2]> = velocities.iter().map(|v| v.map(|x| x as f32)).collect();
    let all = velocities.len() * places;
    Fragment::new()
        .params("roll_out_params", &params)
        .input("velocities", &velocities)
        .output("trajectories", 2 * all)
        .run(ROLL_OUT, Invocations::line(all as u32))
        .floats("trajectories")
}

#[test]
fn roll_out_twin_and_edge_sizes() {
    if skipped() {
        return;
    }
    let velocities = [[1.0, 0.0], [0.5, 1.0], [0.8, -0.6], [-0.4, 0.3], [0.0, 1.0], [1.0, 1e-5], [0.0, 0.0]];
    for (count, places) in [(1, 1), (7, 9), (1, 64), (5, 13)] {
        let velocities = &velocities[..count];
        let along = |heading: f64| -> Vec<f32> {
            let of = |&velocity| {
                (0..places).flat_map(move |at| place(START, heading, velocity, at as f64 * STEP_S))
            };
            velocities.iter().flat_map(of).map(|m| m as f32).collect()
        };
        let got = roll_out(velocities, places);
        assert_close("trajectories", &got, &along(HEADING), PLACE);
        let turned = compare("another heading", &got, &along(HEADING + 0.1), PLACE);
        assert_eq!(turned.is_err(), places > 1);
    }
}

#[test]
fn truth_a_quarter_of_a_circle() {
    if skipped() {
        return;
    }
    // At omega = v / r for the time of a quarter the robot is r ahead and r to the left, looking along HEADING.
    let omega = std::f64::consts::FRAC_PI_2 / (10.0 * STEP_S);
    let got = roll_out(&[[omega, omega]], 11);
    let (sin, cos) = HEADING.sin_cos();
    let want = [START[0] + cos - sin, START[1] + sin + cos].map(|m| m as f32);
    assert_close("end", &got[20..], &want, PLACE);
}

fn sum(costs: &[u8], side: usize, places: usize, trajectories: &[[f32; 2]]) -> Vec<u32> {
    let quads = side.div_ceil(4);
    let mut words = vec![0_u8; 4 * quads * side];
    for (row, costs) in costs.chunks_exact(side).enumerate() {
        words[4 * quads * row..][..side].copy_from_slice(costs);
    }
    let candidates = trajectories.len() / places;
    let params = SumParams {
        side: side as u32,
        quads: quads as u32,
        resolution_m: 0.25,
        candidates: candidates as u32,
        places: places as u32,
        unknown_cost: 200,
    };
    let out = Fragment::new()
        .params("sum_params", &params)
        .input("plan_costs", &words)
        .input("trajectories", trajectories)
        .output("scores", 4 * candidates)
        .run(SUM, Invocations::line(candidates as u32));
    out.words("scores").to_vec()
}

#[test]
fn sum_twin_and_edge_sizes() {
    if skipped() {
        return;
    }
    let mut random = Random(3);
    for (side, candidates, places) in [(1, 1, 1), (7, 63, 5), (8, 64, 9), (9, 65, 12)] {
        let costs: Vec<u8> =
            (0..side * side).map(|_| [0, 50, 253, 254, 255][random.below(5) as usize]).collect();
        // A lattice that avoids the borders of cells, some of it outside of the map.
        let mut coordinate = || (random.below(12) as f32 - 1.0) * 0.25 + 0.1;
        let trajectories: Vec<[f32; 2]> =
            (0..candidates * places).map(|_| [coordinate(), coordinate()]).collect();
        let got = sum(&costs, side, places, &trajectories);
        let twin = |costs: &[u8]| -> Vec<u32> {
            trajectories.chunks_exact(places).flat_map(|way| cost(costs, side, 0.25, way, 200)).collect()
        };
        assert_close("scores", &got, &twin(&costs), EXACT);
        let other: Vec<u8> = costs.iter().map(|cost| cost ^ 1).collect();
        assert!(side == 1 || compare("other costs", &got, &twin(&other), EXACT).is_err());
    }
}

#[test]
fn truth_and_poison_places() {
    if skipped() {
        return;
    }
    let costs = [10, 20, 30, 255];
    let ways = [
        [[0.1, 0.1], [0.1, 0.2], [0.3, 0.2]],
        [[0.3, 0.3], [0.3, 0.1], [0.1, 0.1]],
        [[f32::NAN, 0.1], [f32::INFINITY, 0.1], [0.1, -3.0e38]],
        [[-0.01, 0.1], [0.1, 0.1], [0.1, 3.0e38]],
    ];
    let got = sum(&costs, 2, 3, &ways.concat());
    assert_eq!(got[..4], [30, 20, 2, 0]);
    assert_eq!(got[4..8], [200 + 20 + 10, 20, 3, 1]);
    assert_eq!(got[8..12], [200, 0, 1, 1], "no numbers lie outside, which counts once");
    assert_eq!(got[12..], [200 + 10 + 200, 10, 3, 2]);
}
