//! Costs of trajectories.

use limpid::Config;
use limpid::base::Rigid;
use limpid::map::MapUpdate;
use limpid::offline::score::{Score, Scorer};

use crate::support::gpu::skipped;
use crate::support::scan::{point, run_one, scan, still};

/// A map of 8 m with costs that the test gives.
fn map(cost_of: impl Fn(usize, usize) -> u8) -> MapUpdate {
    let config = Config { scan_map_size_m: 8.0, ..Config::default() };
    let mut out = run_one(&config, &still(scan(0, vec![point([1.05, 0.05, 0.2], 255.0)]))).map;
    out.costmap = (0..80 * 80).map(|cell| cost_of(cell % 80, cell / 80)).collect();
    out
}

/// Sum over the cells along the arc, by many small steps.
fn twin(map: &MapUpdate, [v, omega]: [f64; 2], horizon_s: f64) -> Score {
    let (mut x, mut y, mut heading) = (0.0_f64, 0.0_f64, 0.0_f64);
    let mut score = Score { cost: 0, worst: 0, cells: 0, unknown: 0 };
    let (mut last, steps) = (None, 40_000);
    for step in 0..=steps {
        let cell = [x, y].map(|at| ((at + 4.0) / 0.1).floor() as i64);
        if last != Some(cell) {
            let inside = cell.iter().all(|c| (0..80).contains(c));
            let cost = if inside { map.costmap[(cell[1] * 80 + cell[0]) as usize] } else { 255 };
            score.cost += u32::from(cost);
            score.cells += 1;
            score.unknown += u32::from(cost == 255);
            score.worst = score.worst.max(if cost == 255 { 0 } else { cost.into() });
            last = Some(cell);
        }
        if step < steps {
            let dt = horizon_s / f64::from(steps);
            heading += 0.5 * omega * dt;
            x += v * dt * heading.cos();
            y += v * dt * heading.sin();
            heading += 0.5 * omega * dt;
        }
    }
    score
}

#[test]
fn truth_a_straight_way_costs_the_cells_it_crosses() {
    if skipped() {
        return;
    }
    // A wall of cost 100 three metres ahead, one cell thick.
    let map = map(|x, _| if x == 70 { 100 } else { 1 });
    let mut scorer = Scorer::open(None, 80, 10, 200).unwrap();
    let scores = scorer
        .score_velocities(&map, Rigid::IDENTITY, &[[1.0, 0.0], [0.5, 0.0], [0.0, 0.0], [-1.0, 0.0]], 3.55)
        .unwrap();
    assert_eq!(scores[0], Score { cost: 35 + 100, worst: 100, cells: 36, unknown: 0 });
    assert_eq!(scores[1], Score { cost: 18, worst: 1, cells: 18, unknown: 0 });
    assert_eq!(scores[2], Score { cost: 1, worst: 1, cells: 1, unknown: 0 });
    let way = vec![[0.05, 0.05], [3.55, 0.05], [3.55, 1.05]];
    let given = scorer.score_trajectories(&map, &[way, vec![], vec![[9.0, 9.0]]]).unwrap();
    assert_eq!(given[0], Score { cost: 35 + 100 + 10, worst: 100, cells: 46, unknown: 0 });
    assert_eq!(given[1], Score { cost: 0, worst: 0, cells: 0, unknown: 0 });
    assert_eq!(given[2], Score { cost: 255, worst: 0, cells: 1, unknown: 1 });
}

#[test]
fn twin_on_arcs() {
    if skipped() {
        return;
    }
    let map = map(|x, y| [0, 30, 120, 254, 255][(x / 7 + y / 5) % 5]);
    let mut velocities = Vec::new();
    for v in [0.2, 0.6, 1.0, 1.4] {
        velocities.extend([-1.1, -0.4, 0.013, 0.0, 0.7].map(|omega| [v, omega]));
    }
    let mut scorer = Scorer::open(None, 80, 64, 200).unwrap();
    let scores = scorer.score_velocities(&map, Rigid::IDENTITY, &velocities, 3.0).unwrap();
    for (velocity, score) in velocities.iter().zip(&scores) {
        let want = twin(&map, *velocity, 3.0);
        // Half a cell a step may cut the corner of a cell; along straight lines on an edge rounding chooses the side.
        let corners = want.cells.abs_diff(score.cells);
        assert!(corners <= 1 + want.cells / 6, "{velocity:?}: {score:?} where {want:?} is wanted");
        let share = f64::from(score.cost.abs_diff(want.cost)) / f64::from(want.cost.max(1));
        assert!(share < 0.25 || velocity[1] == 0.0, "{velocity:?}: {score:?} where {want:?} is wanted");
    }
    assert!(scores.iter().any(|score| score.worst == 254) && scores.iter().any(|score| score.unknown > 0));
}

#[test]
fn bad_candidates_are_refused() {
    if skipped() {
        return;
    }
    let map = map(|_, _| 0);
    let mut scorer = Scorer::open(None, 80, 2, 20).unwrap();
    let mut refused = |velocities: &[[f64; 2]], horizon_s: f64, part: &str| {
        let error =
            scorer.score_velocities(&map, Rigid::IDENTITY, velocities, horizon_s).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    };
    refused(&[[1.0, 0.0]; 3], 1.0, "3 candidates; opened for 2");
    refused(&[[1.0, 0.0]], 5.0, "half cells; opened for 19");
    refused(&[[f64::NAN, 0.0]], 1.0, "no numbers");
    refused(&[[1.0, 0.0]], -1.0, "no numbers");
    refused(&[[1.0e300, 0.0]], 1.0, "half cells");
    let error = scorer.score_trajectories(&map, &[vec![[0.0, f64::INFINITY]]]).unwrap_err().to_string();
    assert!(error.contains("no number"), "{error}");
    assert!(Scorer::open(None, 80, 0, 20).is_err() && Scorer::open(None, 80, u32::MAX, 20).is_err());
    let other = MapUpdate { costmap: vec![0; 10], ..map.clone() };
    assert!(scorer.score_velocities(&other, Rigid::IDENTITY, &[[1.0, 0.0]], 0.1).is_err());
}
