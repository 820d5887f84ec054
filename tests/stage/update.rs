//! Occupancy and state per cell.

use bytemuck::cast_slice;
use limpid::config::{Config, Method};
use limpid::gpu::Invocations;
use limpid::stage::camera::update::{UPDATE, UpdateParams, mark_params};

use crate::reference::update::{Cell, Observation};
use crate::support::compare::{EXACT, Tolerance, assert_close};
use crate::support::gpu::{Fragment, Outputs, skipped};
use crate::support::random::Random;

const OCCUPANCY: Tolerance =
    Tolerance { absolute: 1e-6, reason: "f32 against f64: an error of 6e-8 a frame, forgotten by lambda" };

/// Fixed-point one; a power of two, as the job gives it.
pub(super) const SCALE: u32 = 4096;

pub(super) fn params(config: &Config, side: u32, origin_slot: [u32; 2]) -> UpdateParams {
    let temporal = config.method == Method::Temporal;
    UpdateParams {
        side,
        origin_slot_x: origin_slot[0],
        origin_slot_y: origin_slot[1],
        min_hits: config.min_hits,
        confirmations: config.confirmations,
        temporal_window: if temporal { config.temporal_window } else { 1 },
        temporal_hits: if temporal { config.temporal_hits } else { 1 },
        lambda: config.lambda as f32,
        occupied_threshold: config.occupied_threshold as f32,
        free_threshold: config.free_threshold as f32,
        weight_scale: SCALE as f32,
        pad: 0,
    }
}

/// A frame of a map whose cells bear no marks yet; `cell_marks` has tests of its own.
fn fragment(params: &UpdateParams, hits: &[[u32; 4]], seen: &[u32], cells: &[[u32; 4]]) -> Fragment {
    Fragment::new()
        .params("update_params", params)
        .params("cell_marks_params", &mark_params(1, 0, f64::from(params.lambda)))
        .changed("cell_marks", &vec![[0_u32; 2]; cells.len()])
        .input("cell_hits", hits)
        .input("seen_through", seen)
        .changed("cells", cells)
        .output("evidence", seen.len())
        .output("occupancy", seen.len())
        .output("state", seen.len())
}

fn run(params: &UpdateParams, hits: &[[u32; 4]], seen: &[u32], cells: &[[u32; 4]]) -> Outputs {
    fragment(params, hits, seen, cells).run(UPDATE, Invocations::area(params.side, params.side))
}

/// States, without what the frame adds for the passes after it.
fn states(out: &Outputs) -> Vec<u32> {
    out.words("state").iter().map(|word| word & 3).collect()
}

/// (evidence, p, state) of one cell after each of `frames`, run as a 1x1 map.
fn history(config: &Config, frames: &[Observation]) -> Vec<(f32, f32, u32)> {
    let mut cells = vec![[0_u32; 4]];
    let step = |observation: &Observation| {
        let (hits, seen) = encode(*observation, 3);
        let out = run(&params(config, 1, [0, 0]), &[hits], &[seen], &cells);
        cells = cast_slice(out.words("cells")).to_vec();
        (out.floats("evidence")[0], out.floats("occupancy")[0], states(&out)[0])
    };
    frames.iter().map(step).collect()
}

fn encode(observation: Observation, count: u32) -> ([u32; 4], u32) {
    match observation {
        Observation::Hit(w) => ([count, (w * f64::from(SCALE * count)).round() as u32, 7, 0], 0),
        Observation::SeenThrough => ([0; 4], 1),
        Observation::Unseen => ([0; 4], 0),
    }
}

use Observation::{Hit, SeenThrough, Unseen};

#[test]
fn truth_occupied_at_the_eighth_hit_and_free_when_under_half() {
    if skipped() {
        return;
    }
    let frames = [[Hit(1.0); 8].as_slice(), &[Unseen; 2], &[SeenThrough; 3]].concat();
    let seen = history(&Config::default(), &frames);
    let states: Vec<u32> = seen.iter().map(|s| s.2).collect();
    // 1 - 0.85^7 = 0.679, 1 - 0.85^8 = 0.728; then 0.618, 0.526, 0.447.
    assert_eq!(states, [0, 0, 0, 0, 0, 0, 0, 2, 2, 2, 2, 2, 1]);
    assert_eq!(seen[8], (-1.0, seen[7].1, 2), "unseen keeps p to the bit");
    let p: Vec<f32> = seen.iter().map(|s| s.1).collect();
    let want: Vec<f64> = (1..=8).map(|n| 1.0 - 0.85_f64.powi(n)).collect();
    assert_close("p", &p[..8], &want, OCCUPANCY);
}

#[test]
fn truth_weak_hits_never_mark_and_confirmations_delay() {
    if skipped() {
        return;
    }
    let weak = history(&Config::default(), &[Hit(0.6); 40]);
    assert!(weak.iter().all(|s| s.2 == 0), "p converges to 0.6");
    assert!((f64::from(weak[39].1) - 0.6).abs() < 2e-3);
    let config = Config { confirmations: 12, ..Config::default() };
    let frames = [[Hit(1.0); 11].as_slice(), &[Unseen], &[Hit(1.0); 1]].concat();
    let first = history(&config, &frames).iter().position(|s| s.2 == 2);
    assert_eq!(first, Some(12), "the twelfth observed frame, which is the thirteenth frame");
    let broken = [[Hit(1.0); 11].as_slice(), &[SeenThrough], &[Hit(1.0); 11]].concat();
    assert!(history(&config, &broken).iter().all(|s| s.2 == 0), "only consecutive ones count");
}

#[test]
fn truth_temporal_rejection_counts_observed_frames() {
    if skipped() {
        return;
    }
    let config = Config { method: Method::Temporal, ..Config::default() };
    let frames =
        [SeenThrough, Hit(1.0), Hit(1.0), Unseen, Hit(1.0), SeenThrough, SeenThrough, SeenThrough, Hit(1.0)];
    let evidence: Vec<f32> = history(&config, &frames).iter().map(|s| s.0).collect();
    assert_eq!(evidence, [0.0, -1.0, -1.0, -1.0, 1.0, 0.0, 0.0, 0.0, -1.0]);
}

fn observation(random: &mut Random) -> Observation {
    match random.below(10) {
        0..6 => Hit(f64::from(random.below(SCALE.into())) / f64::from(SCALE)),
        6..8 => SeenThrough,
        _ => Unseen,
    }
}

fn compare_with_twin(config: &Config, side: u32, frames: usize, seed: u64) {
    let mut random = Random(seed);
    let count = (side * side) as usize;
    let mut twins = vec![Cell::default(); count];
    let mut ring = vec![[0_u32; 4]; count];
    let near =
        |p: f64| [config.occupied_threshold, config.free_threshold].iter().any(|t| (p - t).abs() < 1e-5);
    for _ in 0..frames {
        let seen: Vec<Observation> = (0..count).map(|_| observation(&mut random)).collect();
        let (hits, through): (Vec<_>, Vec<_>) = seen.iter().map(|&s| encode(s, 4)).unzip();
        let out = run(&params(config, side, [2 % side, 5 % side]), &hits, &through, &ring);
        ring = cast_slice(out.words("cells")).to_vec();
        let evidence: Vec<f64> =
            seen.iter().zip(&mut twins).map(|(&s, cell)| cell.observe(config, config.lambda, s)).collect();
        assert!(!twins.iter().any(|cell| near(cell.p)), "choose another seed: p on a threshold");
        let p: Vec<f64> = twins.iter().map(|cell| cell.p).collect();
        let states: Vec<u32> = twins.iter().map(|cell| cell.state as u32).collect();
        assert_close("evidence", &out.floats("evidence"), &evidence, OCCUPANCY);
        assert_close("occupancy", &out.floats("occupancy"), &p, OCCUPANCY);
        assert_close("state", &self::states(&out), &states, EXACT);
        let was = |bit: u32| out.words("state").iter().map(|word| word & bit != 0).collect::<Vec<_>>();
        assert_eq!(was(4), seen.iter().map(|s| matches!(s, Hit(_))).collect::<Vec<_>>());
        assert_eq!(was(8), seen.iter().map(|s| *s == SeenThrough).collect::<Vec<_>>());
    }
}

#[test]
fn twin_on_random_histories() {
    if skipped() {
        return;
    }
    compare_with_twin(&Config::default(), 9, 14, 31);
    compare_with_twin(&Config { confirmations: 3, lambda: 0.4, ..Config::default() }, 9, 8, 32);
    compare_with_twin(&Config { method: Method::Temporal, lambda: 0.5, ..Config::default() }, 9, 8, 33);
}

#[test]
fn edge_sizes() {
    if skipped() {
        return;
    }
    fragment(&params(&Config::default(), 1, [0, 0]), &[[0; 4]], &[0], &[[0; 4]]).refuses_nothing(UPDATE);
    for side in [1, 7, 8, 9] {
        compare_with_twin(&Config::default(), side, 1, 40);
    }
}

#[test]
fn too_few_hits_are_none_and_the_highest_hit_is_kept() {
    if skipped() {
        return;
    }
    let three = params(&Config { min_hits: 3, ..Config::default() }, 1, [0, 0]);
    let out = run(&three, &[[2, 2 * SCALE, 90, 0]], &[0], &[[0; 4]]);
    assert_eq!((out.floats("evidence")[0], out.words("cells")[3]), (-1.0, 0));
    let out = run(&three, &[[3, 3 * SCALE, 90, 0]], &[0], &[[0, 0, 0, 50]]);
    assert_eq!((out.floats("evidence")[0], out.words("cells")[3]), (1.0, 90));
    let out = run(&three, &[[3, 3 * SCALE, 40, 0]], &[0], &[[0, 0, 0, 50]]);
    assert_eq!(out.words("cells")[3], 50, "the highest so far");
    let out = run(&three, &[[0; 4]], &[1], &[[0, 0, 0, 50]]);
    assert_eq!((out.words("cells")[3], states(&out)[0]), (0, 1), "a free cell has none");
}

#[test]
fn poison_stays_in_its_cell() {
    if skipped() {
        return;
    }
    let one = params(&Config::default(), 2, [0, 0]);
    let hits = [[u32::MAX, u32::MAX, u32::MAX, 1], [1, SCALE, 1, 0], [0, 9, 9, 0], [0; 4]];
    let out = run(
        &one,
        &hits,
        &[7, 0, 0, 1],
        &[[0; 4], [0.5_f32.to_bits(), 0xffff_ff02, u32::MAX, 3], [0; 4], [0; 4]],
    );
    assert!(out.floats("evidence").iter().all(|e| (-1.0..=1.0).contains(e)));
    assert!(out.floats("occupancy").iter().all(|p| (0.0..=1.0).contains(p)));
    assert_eq!(states(&out), [0, 2, 0, 1]);
    assert_eq!(out.floats("evidence")[2], -1.0, "weight without hits says nothing");
}
