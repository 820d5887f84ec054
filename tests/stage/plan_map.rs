//! Classes and costs of the plan map.

use limpid::gpu::Invocations;
use limpid::stage::plan_map::{PLAN_MAP, PlanMapParams};

use crate::reference::plan_map::plan;
use crate::support::compare::{EXACT, assert_close};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

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
    let out = Fragment::new()
        .params("plan_map_params", &params)
        .input("cell_class", &kinds)
        .input("inflation", &spread)
        .input("obstacle_value", &vec![0.25_f32; cells])
        .output("plan_costs", side * quads)
        .output("plan_classes", side * quads)
        .output("cell_values", 4 * cells)
        .run(PLAN_MAP, Invocations::line((side * quads) as u32));
    let bytes = |name: &str| -> Vec<u32> {
        let words = out.words(name).chunks_exact(quads);
        words.flat_map(|row| row.iter().flat_map(|w| w.to_le_bytes()).take(side)).map(u32::from).collect()
    };
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
