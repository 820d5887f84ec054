//! Costs from verdicts and what was spread around obstacles.

use limpid::gpu::Invocations;
use limpid::map::Verdict;
use limpid::stage::map::goal_costs::{GOAL_COSTS, params};

use crate::reference::goal_costs::cost;
use crate::reference::plan_map::plan;
use crate::support::compare::{EXACT, assert_close};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

const INSCRIBED: u32 = 1 << 31;

fn run(side: u32, bases: &[u8], spread: &[u32]) -> Vec<u8> {
    let verdicts: Vec<u32> = bases.iter().map(|&base| Verdict::pack(base, 5, Some(1), 900).0).collect();
    let quads = side.div_ceil(4);
    let out = Fragment::new()
        .params("goal_costs_params", &params(side))
        .input("verdicts", &verdicts)
        .input("inflation", spread)
        .output("costmap", (quads * side) as usize)
        .run(GOAL_COSTS, Invocations::area(quads, side));
    let bytes: Vec<u8> = out.words("costmap").iter().flat_map(|word| word.to_le_bytes()).collect();
    bytes.chunks_exact(4 * quads as usize).flat_map(|row| row[..side as usize].to_vec()).collect()
}

#[test]
fn truth_no_cost_falls_and_unknown_yields_to_253_alone() {
    if skipped() {
        return;
    }
    let half = 2040;
    let bases = [0, 50, 200, 254, 255, 0, 50, 254, 255];
    let spread = [
        half,
        half,
        half,
        half,
        half,
        half | INSCRIBED,
        half | INSCRIBED,
        half | INSCRIBED,
        half | INSCRIBED,
    ];
    // 1 + 251 / 2 = 126
    assert_eq!(run(3, &bases, &spread), [126, 126, 200, 254, 255, 253, 253, 254, 253]);
    assert_eq!(run(3, &bases, &[0; 9]), bases);
}

#[test]
fn twin_and_the_plan_map_of_a_scan_at_all_sizes() {
    if skipped() {
        return;
    }
    let mut random = Random(71);
    for side in [1, 7, 8, 9, 31, 33] {
        let cells = (side * side) as usize;
        let classes: Vec<u32> = (0..cells).map(|_| random.below(5)).collect();
        let bases: Vec<u8> = classes.iter().map(|&class| [255, 0, 254, 50, 254][class as usize]).collect();
        let spread: Vec<u32> = (0..cells)
            .map(|_| match random.below(3) {
                0 => 0,
                1 => random.below(9000) + 1,
                _ => (random.below(9000) + 1) | INSCRIBED,
            })
            .collect();
        let got = run(side, &bases, &spread);
        let steps = |at: usize| (spread[at] & !INSCRIBED, spread[at] >= INSCRIBED);
        let want: Vec<u32> = (0..cells).map(|at| cost(bases[at].into(), steps(at).0, steps(at).1)).collect();
        assert_close("costs", &got, &want, EXACT);
        let of_scan: Vec<u32> =
            (0..cells).map(|at| plan(classes[at], steps(at).0, steps(at).1, 50).1).collect();
        assert_close("costs of the plan map", &got, &of_scan, EXACT);
    }
}

#[test]
fn poison_stays_within_the_scale() {
    if skipped() {
        return;
    }
    let costs = run(2, &[0, 255, 254, 50], &[u32::MAX; 4]);
    assert_eq!(costs, [253, 253, 254, 253]);
    assert_eq!(run(2, &[0, 255, 254, 50], &[u32::MAX >> 1; 4]), [252, 255, 254, 252]);
}
