//! Classes and costs of the plan map.

use limpid::gpu::Invocations;
use limpid::stage::map::plan_map::{PLAN_MAP, PlanMapParams};

use crate::reference::plan_map::plan;
use crate::support::compare::{EXACT, assert_close};
use crate::support::gpu::{Fragment, Outputs, skipped};
use crate::support::random::Random;

fn run(params: &PlanMapParams, cells: &[u32], inflation: &[u32], values: &[f32]) -> Outputs {
    let words = (params.side * params.quads) as usize;
    Fragment::new()
        .params("plan_map_params", params)
        .input("cell_class", cells)
        .input("inflation", inflation)
        .input("obstacle_value", values)
        .output("plan_costs", words)
        .output("plan_classes", words)
        .output("cell_values", 4 * cells.len())
        .run(PLAN_MAP, Invocations::area(params.quads, params.side))
}

/// The bytes of a grid, rows without their padding.
fn bytes(out: &Outputs, name: &str, side: usize) -> Vec<u32> {
    let rows = out.words(name).chunks_exact(side.div_ceil(4));
    rows.flat_map(|row| row.iter().flat_map(|w| w.to_le_bytes()).take(side)).map(u32::from).collect()
}

fn compare_with_twin(side: usize, seed: u64) {
    let mut random = Random(seed);
    let cells = side * side;
    let quads = side.div_ceil(4);
    let kinds: Vec<u32> = (0..cells).map(|_| random.below(5)).collect();
    let spread: Vec<[u32; 2]> = (0..cells)
        .map(|_| match random.below(4) {
            0 => [0, 0],
            1 => [random.below(9000) + 1, 1],
            _ => [random.below(9000) + 1, 0],
        })
        .collect();
    let params =
        PlanMapParams { side: side as u32, quads: quads as u32, passable_cost: 50, solid_value: 1.0 };
    let packed: Vec<u32> = spread.iter().map(|[steps, close]| steps | close << 31).collect();
    let out = run(&params, &kinds, &packed, &vec![0.25_f32; cells]);
    let bytes = |name: &str| bytes(&out, name, side);
    let want: Vec<(u32, u32)> =
        kinds.iter().zip(&spread).map(|(&kind, &[steps, close])| plan(kind, steps, close > 0, 50)).collect();
    assert_close("class", &bytes("plan_classes"), &want.iter().map(|w| w.0).collect::<Vec<_>>(), EXACT);
    assert_close("cost", &bytes("plan_costs"), &want.iter().map(|w| w.1).collect::<Vec<_>>(), EXACT);
    assert!(out.floats("cell_values").iter().all(|value| (0.0..=1.0).contains(value)));
}

#[test]
fn twin_and_edge_sizes() {
    if skipped() {
        return;
    }
    for (side, seed) in [(1, 1), (3, 2), (4, 3), (5, 4), (16, 5), (17, 6)] {
        compare_with_twin(side, seed);
    }
}

const INSCRIBED: u32 = 1 << 31;

#[test]
fn truth_classes_costs_and_values() {
    if skipped() {
        return;
    }
    let params = PlanMapParams { side: 3, quads: 1, passable_cost: 50, solid_value: 2.0 };
    let glass = 4 | 2040 << 8 | 2040 << 20;
    // Unknown, free, solid; passable, glass, unknown near an obstacle; free within the robot's radius, passable weakly
    // and strongly inflated.
    let cells = [0, 1, 2 | 4080 << 20, 3, glass, 0, 1, 3, 3];
    let inflation = [0, 0, 4080, 0, 2040, 4080, INSCRIBED | 4080, 2, 4080];
    let values = [0.0, 0.0, 1.5, 0.25, 0.0, 0.0, 0.0, 0.25, 0.25];
    let out = run(&params, &cells, &inflation, &values);
    assert_eq!(bytes(&out, "plan_classes", 3), [0, 1, 2, 3, 4, 0, 5, 3, 5]);
    assert_eq!(bytes(&out, "plan_costs", 3), [255, 0, 254, 50, 254, 255, 253, 50, 252]);
    // Unknown gives way within the robot's radius alone; free and passable cells are inflated beyond it.
    let near =
        run(&params, &[0, 0, 0, 1, 3, 0, 0, 0, 0], &[4080, INSCRIBED | 1, 1, 1, 4080, 0, 0, 0, 0], &[0.0; 9]);
    assert_eq!(bytes(&near, "plan_classes", 3), [0, 5, 0, 5, 5, 0, 0, 0, 0]);
    assert_eq!(bytes(&near, "plan_costs", 3), [255, 253, 255, 1, 252, 255, 255, 255, 255]);
    let values = out.floats("cell_values");
    let cell = |at: usize| &values[4 * at..4 * at + 4];
    // I_TP, I_FP, I_FN, I_inflate: shares of full scale times the value of a solid cell.
    assert_eq!(cell(2), [1.5, 0.0, 0.0, 2.0]);
    assert_eq!(cell(3), [0.0, 0.25, 0.0, 0.0]);
    assert_eq!(cell(4), [0.0, 0.0, 1.0, 1.0]);
}

#[test]
fn poison_stays_a_class_and_a_cost() {
    if skipped() {
        return;
    }
    let params = PlanMapParams { side: 2, quads: 1, passable_cost: 50, solid_value: 1.0 };
    // No such class, the most inflation, and a strength in the word of a free cell.
    let out = run(&params, &[u32::MAX, 1, 2, 4], &[0, u32::MAX, INSCRIBED - 1, 0], &[3.0e38; 4]);
    let (classes, costs) = (bytes(&out, "plan_classes", 2), bytes(&out, "plan_costs", 2));
    assert_eq!((&classes[1..], &costs[1..]), (&[5, 2, 4][..], &[253, 254, 254][..]));
    assert!(out.floats("cell_values").iter().all(|value| value.is_finite()));
    let none = run(&params, &[0; 4], &[0; 4], &[0.0; 4]);
    assert!(none.floats("cell_values").iter().all(|&value| value == 0.0));
}
