//! Costs from verdicts and what was spread around obstacles.

use limpid::gpu::Invocations;
use limpid::map::{CellClass, Verdict};
use limpid::stage::map::goal_costs::{GOAL_COSTS, params};

use crate::reference::goal_costs::cost;
use crate::reference::plan_map::plan;
use crate::support::compare::{EXACT, assert_close};
use crate::support::gpu::{Fragment, cells_of_quads, skipped};
use crate::support::random::Random;

const INSCRIBED: u32 = 1 << 31;

fn run(side: u32, bases: &[u8], spread: &[u32]) -> Vec<u8> {
    let verdicts: Vec<u32> = bases.iter().map(|&base| Verdict::pack(base, 5, Some(1), 900).0).collect();
    let [costs, _] = costs_and_classes(side, &verdicts, spread);
    costs
}

fn costs_and_classes(side: u32, verdicts: &[u32], spread: &[u32]) -> [Vec<u8>; 2] {
    let quads = side.div_ceil(4);
    let out = Fragment::new()
        .params("goal_costs_params", &params(side))
        .input("verdicts", verdicts)
        .input("inflation", spread)
        .output("costmap", (quads * side) as usize)
        .output("cell_classes", (quads * side) as usize)
        .run(GOAL_COSTS, Invocations::area(quads, side));
    ["costmap", "cell_classes"].map(|grid| cells_of_quads(out.words(grid), side))
}

#[test]
fn classes_follow_row_and_cost() {
    if skipped() {
        return;
    }
    let verdict = |base, row| Verdict::pack(base, row, Some(0), 7).0;
    let verdicts = [
        verdict(254, 1),
        verdict(254, 2),
        verdict(254, 3),
        verdict(254, 4),
        verdict(50, 4),
        verdict(0, 5),
        verdict(50, 7),
        verdict(255, 10),
        verdict(255, 11),
    ];
    use CellClass::{Free, Inflated, Passable, Solid, Transparent, Unknown};
    let [_, alone] = costs_and_classes(3, &verdicts, &[0; 9]);
    let want = [Transparent, Solid, Transparent, Solid, Passable, Free, Passable, Unknown, Unknown];
    assert_eq!(alone, want.map(|class| class as u8));
    let [_, near] = costs_and_classes(3, &verdicts, &[2040; 9]);
    let want = [Transparent, Solid, Transparent, Solid, Inflated, Inflated, Inflated, Unknown, Unknown];
    assert_eq!(near, want.map(|class| class as u8));
    let [_, inscribed] = costs_and_classes(3, &verdicts, &[2040 | INSCRIBED; 9]);
    assert_eq!(inscribed[4..], [Inflated as u8; 5]);
}

#[test]
fn classes_are_those_of_the_map_for_every_row() {
    if skipped() {
        return;
    }
    let mut random = Random(72);
    let side = 33;
    let verdicts: Vec<Verdict> = (0..side * side)
        .map(|_| {
            let base = [0, 50, 254, 255][random.below(4) as usize];
            Verdict::pack(base, random.below(12), Some(random.below(16) as usize), random.below(900))
        })
        .collect();
    let spread: Vec<u32> =
        (0..side * side).map(|_| [0, 900, 4080, 4080 | INSCRIBED][random.below(4) as usize]).collect();
    let words: Vec<u32> = verdicts.iter().map(|verdict| verdict.0).collect();
    let [costs, classes] = costs_and_classes(side, &words, &spread);
    let want: Vec<u32> =
        verdicts.iter().zip(&costs).map(|(&verdict, &cost)| CellClass::of(verdict, cost) as u32).collect();
    assert_close("classes", &classes, &want, EXACT);
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
