//! Occupancy by evidence that counts trust, one frame after another.

use bytemuck::cast_slice;
use glam::DVec2;
use limpid::Config;
use limpid::gpu::Invocations;
use limpid::sensor::{CameraModel, Distortion};
use limpid::stage::camera::update::{UPDATE_BY_EVIDENCE, evidence_params, mark_params};

use crate::reference::evidence::{Cell, Look};
use crate::stage::update::{self, SCALE};
use crate::support::compare::{EXACT, Tolerance, assert_close, compare};
use crate::support::gpu::{Fragment, Outputs, skipped};
use crate::support::random::Random;

const EVIDENCE: Tolerance = Tolerance {
    absolute: 3e-4,
    reason: "f32, pow of the driver at an exponent of 8, and R in steps of 1/4096; forgotten by 0.95 a look",
};

/// Words of `seen_through`: whole, and the bit of a neighbour.
const ONE: f64 = 65535.0;
const BESIDE: u32 = 0x1_0000;

/// f of 400 pixels: a cell 2 m away needs three hits, one from 2.45 m on two.
fn camera() -> CameraModel {
    let (width, height) = (640, 480);
    CameraModel { width, height, fx: 320.0, fy: 500.0, cx: 320.0, cy: 240.0, distortion: Distortion::None }
}

const FOCAL_PX: f64 = 400.0;

/// Where the camera stands in the window.
const AT_M: DVec2 = DVec2::new(-1.975, 0.025);

/// (cells, cell_marks).
type Ring = (Vec<[u32; 4]>, Vec<[u32; 2]>);

fn empty(cells: usize) -> Ring {
    (vec![[0; 4]; cells], vec![[0; 2]; cells])
}

fn encode(look: Look) -> ([u32; 4], u32) {
    let share = (look.share * ONE).round() as u32;
    let word = share | if look.beside { BESIDE } else { 0 };
    match look.hits {
        Some((n, sum)) => ([n as u32, (sum * f64::from(SCALE)).round() as u32, 20_000, !9000], word),
        None => ([0, 0, u32::from(look.floor), 0], word),
    }
}

fn fragment(config: &Config, side: u32, ring: &Ring, tick: u32, timed: bool, looks: &[Look]) -> Fragment {
    let (hits, seen): (Vec<[u32; 4]>, Vec<u32>) = looks.iter().map(|&look| encode(look)).unzip();
    Fragment::new()
        .params("update_params", &update::params(config, side, [2 % side, 5 % side]))
        .params("evidence_params", &evidence_params(config, &camera(), AT_M))
        .params("cell_marks_params", &mark_params(tick, 1, 0.85))
        .input("cell_hits", &hits)
        .input("seen_through", &seen)
        .changed("cells", &ring.0)
        .changed("cell_marks", &ring.1)
        .output("evidence", looks.len())
        .output("occupancy", looks.len())
        .output("state", looks.len())
        .constants(&[("timed", timed), ("lowest", true)])
}

fn run_as(config: &Config, side: u32, ring: &Ring, tick: u32, timed: bool, looks: &[Look]) -> Outputs {
    fragment(config, side, ring, tick, timed, looks).run(UPDATE_BY_EVIDENCE, Invocations::area(side, side))
}

fn kept(out: &Outputs) -> Ring {
    (cast_slice(out.words("cells")).to_vec(), cast_slice(out.words("cell_marks")).to_vec())
}

/// States of one cell 2 m away after each look, three frames a tenth of a second; and what it holds at the end: for and against.
fn history_as(config: &Config, looks: &[Look]) -> (Vec<u32>, [f32; 2], Ring) {
    let mut ring = empty(1);
    let states = looks.iter().zip(1_u32..).map(|(&look, number)| {
        let out = run_as(config, 1, &ring, 4 * number, false, &[look]);
        ring = kept(&out);
        out.words("state")[0] & 3
    });
    let states = states.collect();
    let [support, _, opposed, _] = ring.0[0];
    (states, [support, opposed].map(f32::from_bits), ring)
}

fn history(looks: &[Look]) -> (Vec<u32>, [f32; 2]) {
    let (states, holds, _) = history_as(&spec(), looks);
    (states, holds)
}

/// The spec's values.
fn spec() -> Config {
    Config { evidence_exponent: 8.0, evidence_least_hits: 2.0, ..Config::default() }
}

const NOTHING: Look = Look { hits: None, share: 0.0, floor: false, beside: false, distance_m: 2.0 };
const SURE: Look = Look { hits: Some((5.0, 5.0)), ..NOTHING };
const CLEAR: Look = Look { share: 1.0, ..NOTHING };

#[test]
fn truth_sure_hits_mark_at_the_second_look_and_six_clear_ones_release() {
    if skipped() {
        return;
    }
    let (states, holds) = history(&[SURE, SURE]);
    assert_eq!(states, [0, 2]);
    assert_close("for and against", &holds, &[1.95, 0.0], EVIDENCE);
    // An hour at 30 Hz cannot be run here; 120 looks reach the most that is kept, 8.75, as an hour would (next test).
    let (states, holds) = history(&[[SURE; 120].as_slice(), &[CLEAR; 7]].concat());
    assert_eq!(states[119..], [2, 2, 2, 2, 2, 2, 1, 1], "after six clear looks");
    assert_close("for", &holds[..1], &[8.75 * 0.95_f64.powi(7)], EVIDENCE);
}

#[test]
fn truth_evidence_does_not_grow_with_hours() {
    if skipped() {
        return;
    }
    let (_, [minute, _]) = history(&[SURE; 60]);
    let (_, [longer, _]) = history(&[SURE; 61]);
    assert_eq!((minute, longer), (8.75, 8.75), "another look adds nothing: no later one does");
    let (_, [_, free]) = history(&[CLEAR; 60]);
    assert!((f64::from(free) - 5.0).abs() < 1e-3, "against: at most 1 / (1 - 0.8), and {free}");
    // So what comes into a cell that was free for an hour is seen within five looks.
    let (states, _) = history(&[[CLEAR; 60].as_slice(), &[SURE; 5]].concat());
    assert_eq!(states[59..], [1, 1, 1, 1, 1, 2]);
}

#[test]
fn truth_reliability_sets_the_speed_and_weak_hits_mark_beside_strong_ones_alone() {
    if skipped() {
        return;
    }
    let weak = |mean_r: f64, beside| Look { hits: Some((5.0, 5.0 * mean_r)), beside, ..NOTHING };
    // (0.8 / 0.9)^8 = 0.39: five looks to 1.75. (0.6 / 0.9)^8 = 0.039 converges to 0.78.
    let first = |looks: &[Look]| history(looks).0.iter().position(|state| *state == 2);
    assert_eq!(first(&[weak(0.9, false); 4]), Some(1), "0.9 is enough");
    assert_eq!(first(&[weak(0.8, false); 9]), Some(4));
    assert_eq!(first(&[weak(0.6, false); 60]), None);
    assert_eq!(first(&[weak(0.6, true); 20]), Some(16), "0.78 (1 - 0.95^n) >= 0.44");
    let few = |hits: f64| Look { hits: Some((hits, hits)), ..NOTHING };
    // n0 = 7.5e-5 (400 / 2)^2 = 3.
    assert_eq!([1.0, 2.0, 3.0].map(|n| first(&[few(n); 9])), [Some(5), Some(2), Some(1)]);
    assert_eq!(first(&[SURE]), None, "seen once");
}

#[test]
fn truth_looks_through_compete_with_hits() {
    if skipped() {
        return;
    }
    let contested = |share| Look { share, ..SURE };
    let last = |share| *history(&[contested(share); 60]).0.last().unwrap();
    // What is against goes towards 5 b. 8.75 is twice that for b up to 0.875.
    assert_eq!([0.0, 0.5, 0.75, 0.8].map(last), [2, 2, 2, 2], "once occupied it stays so");
    let found_free =
        |share| *history(&[[CLEAR; 9].as_slice(), &[contested(share); 60]].concat()).0.last().unwrap();
    assert_eq!([0.75, 0.9].map(found_free), [2, 1], "but does not become so");
    let floor = Look { floor: true, ..NOTHING };
    let (states, [_, against]) = history(&[floor; 3]);
    assert_eq!(states, [1, 1, 1], "a floor point frees");
    assert_close("against", &[against], &[0.07 * (1.0 + 0.8 + 0.64)], EVIDENCE);
    let out = run_as(&spec(), 1, &empty(1), 1, false, &[NOTHING]);
    assert_eq!((kept(&out), out.floats("evidence")[0]), (empty(1), -1.0), "nothing seen, nothing changed");
}

#[test]
fn truth_heights_are_forgotten_with_the_evidence() {
    if skipped() {
        return;
    }
    let top = |clear: usize| {
        let looks = [[SURE; 3].as_slice(), &vec![CLEAR; clear]].concat();
        let (states, [support, _], ring) = history_as(&spec(), &looks);
        (states.last().copied(), support, ring.0[0][3])
    };
    let (state, support, steps) = top(3);
    assert_eq!((state, steps), (Some(1), 20_000), "free, but {support} is left");
    let (state, support, steps) = top(60);
    assert_eq!((state, steps), (Some(1), 0), "{support} is left");
}

#[test]
fn confirmations_and_temporal_rejection_hold_as_for_the_mean() {
    if skipped() {
        return;
    }
    let first =
        |config: &Config, looks: &[Look]| history_as(config, looks).0.iter().position(|state| *state == 2);
    let config = Config { confirmations: 6, ..spec() };
    assert_eq!(first(&config, &[SURE; 8]), Some(5));
    assert_eq!(first(&config, &[SURE, SURE, SURE, CLEAR, SURE, SURE, SURE]), None);
    let config = Config { method: limpid::config::Method::Temporal, ..spec() };
    assert_eq!(first(&config, &[SURE; 5]), Some(3), "the third hit is the first that counts");
}

fn random_look(random: &mut Random, distance_m: f64) -> Look {
    let n = f64::from(random.below(9) + 1);
    let beside = random.below(4) == 0;
    let share = |most: u64| f64::from(random.below(most)) / ONE;
    let [low, share] = [20_000, 65_536].map(share).map(|share| if beside { 0.0 } else { share });
    let mean_r = f64::from(random.below(2048) + 2048) / 4096.0;
    match random.below(10) {
        0..5 => Look { hits: Some((n, n * mean_r)), share: low, floor: false, beside, distance_m },
        5..7 => Look { share, beside, distance_m, ..NOTHING },
        7..8 => Look { floor: true, share, distance_m, ..NOTHING },
        _ => Look { distance_m, ..NOTHING },
    }
}

/// Runs frames of random looks on the GPU and on the twin. Gives how many cells changed states.
fn compare_with_twin(side: u32, timed: bool, frames: u32, seed: u64) -> usize {
    let (mut random, cells) = (Random(seed), (side * side) as usize);
    let (mut ring, mut twins, mut changes) = (empty(cells), vec![Cell::default(); cells], 0);
    // Cells that came so near a threshold that f32 may decide otherwise are left out from there on.
    let mut doubtful = vec![false; cells];
    let mut tick = 1;
    for _ in 0..frames {
        tick += random.below(5);
        let distance_m = |i: usize| {
            let centre = DVec2::new((i as u32 % side) as f64 + 0.5, (i as u32 / side) as f64 + 0.5) * 0.05;
            (centre - AT_M).length()
        };
        let looks: Vec<Look> = (0..cells).map(|i| random_look(&mut random, distance_m(i))).collect();
        let out = run_as(&spec(), side, &ring, tick, timed, &looks);
        ring = kept(&out);
        let before: Vec<_> = twins.iter().map(|twin| twin.state).collect();
        let a: Vec<f64> = twins
            .iter_mut()
            .zip(&looks)
            .map(|(twin, &look)| twin.look(look, FOCAL_PX, tick, timed))
            .collect();
        changes += before.iter().zip(&twins).filter(|(state, twin)| **state != twin.state).count();
        doubtful.iter_mut().zip(&twins).for_each(|(doubt, twin)| *doubt |= twin.margin() < EVIDENCE.absolute);
        let sure = |values: &[f64]| -> Vec<f64> {
            values.iter().zip(&doubtful).filter(|(_, doubt)| !**doubt).map(|(value, _)| *value).collect()
        };
        let share = |twin: &Cell| match twin.support + twin.opposed {
            0.0 => 0.0,
            all => twin.support / all,
        };
        let occupancy: Vec<f64> = twins.iter().map(share).collect();
        let states: Vec<f64> = twins.iter().map(|twin| f64::from(twin.state as u32)).collect();
        let got: Vec<f64> = out.words("state").iter().map(|word| f64::from(word & 3)).collect();
        let of = |name: &str| -> Vec<f64> { out.floats(name).into_iter().map(f64::from).collect() };
        assert_close("a", &sure(&of("evidence")), &sure(&a), EVIDENCE);
        assert_close("occupancy", &sure(&of("occupancy")), &sure(&occupancy), EVIDENCE);
        assert_close("state", &sure(&got), &sure(&states), EXACT);
    }
    assert!(doubtful.iter().filter(|doubt| **doubt).count() <= 1 + cells / 5, "{doubtful:?}");
    changes
}

#[test]
fn twin_of_random_looks_at_all_sizes() {
    if skipped() {
        return;
    }
    let mut changes = 0;
    for (side, timed) in [(1, true), (7, false), (8, true), (9, false), (17, true)] {
        changes += compare_with_twin(side, timed, 20, 60 + u64::from(side));
    }
    assert!(changes > 500, "{changes} changes of state");
    fragment(&spec(), 1, &empty(1), 1, false, &[SURE]).refuses_nothing(UPDATE_BY_EVIDENCE);
}

#[test]
fn control_the_comparison_turns_red() {
    if skipped() {
        return;
    }
    let out = run_as(&spec(), 1, &empty(1), 1, false, &[Look { hits: Some((5.0, 4.0)), ..NOTHING }]);
    let want = (0.8_f64 / 0.9).powi(8);
    assert!(compare("a", &out.floats("evidence"), &[want], EVIDENCE).is_ok());
    assert!(compare("a", &out.floats("evidence"), &[(0.8_f64 / 0.9).powi(9)], EVIDENCE).is_err());
}

#[test]
fn truth_cameras_that_overlap_count_no_more_than_one() {
    if skipped() {
        return;
    }
    // Two cameras of 30 Hz, in turns every 2 or 1 ticks, and one camera: 0.2 s each.
    let after = |ticks: &[u32]| {
        let ring = ticks.iter().fold(empty(1), |ring, &tick| {
            kept(&run_as(&spec(), 1, &ring, tick, true, &[Look { hits: Some((5.0, 4.0)), ..NOTHING }]))
        });
        f64::from(f32::from_bits(ring.0[0][0]))
    };
    let (one, two) =
        (after(&[1, 4, 7, 10, 13, 16, 19]), after(&[1, 3, 4, 6, 7, 9, 10, 12, 13, 15, 16, 18, 19]));
    assert!((one - two).abs() < 1e-3 && one > 1.0, "{one}, {two}");
    assert!((after(&[1, 1001]) - after(&[1, 5])).abs() < 1e-3, "no look counts more than one");
}

#[test]
fn poison_stays_in_its_cell_and_in_bounds() {
    if skipped() {
        return;
    }
    let config = spec();
    let hits = [[u32::MAX; 4], [0, 9, 9, 0], [1, 0, 7, !7], [0; 4]];
    let poison = [u32::MAX, f32::NAN.to_bits(), f32::INFINITY.to_bits(), 0xff80_0000];
    let cells = vec![poison, [0; 4], [0; 4], poison];
    let out = Fragment::new()
        .params("update_params", &update::params(&config, 2, [0, 0]))
        .params("evidence_params", &evidence_params(&config, &camera(), DVec2::new(0.025, 0.025)))
        .params("cell_marks_params", &mark_params(u32::MAX, 15, 0.85))
        .input("cell_hits", &hits)
        .input("seen_through", &[u32::MAX, u32::MAX, 0, 0])
        .changed("cells", &cells)
        .changed("cell_marks", &[[3, u32::MAX]; 4])
        .output("evidence", 4)
        .output("occupancy", 4)
        .output("state", 4)
        .constants(&[("timed", true), ("lowest", true)])
        .run(UPDATE_BY_EVIDENCE, Invocations::area(2, 2));
    assert_eq!(kept(&out).0[3], poison, "what nothing was seen of keeps its bits");
    let states: Vec<u32> = out.words("state").iter().map(|word| word & 3).collect();
    assert_eq!(states[1..3], [1, 0], "weight without hits says nothing, hits without weight nothing for");
    let evidence = out.floats("evidence");
    assert_eq!(evidence[1..], [0.0, 0.0, -1.0]);
    assert!((0.0..=1.0).contains(&evidence[0]), "{evidence:?}");
}
