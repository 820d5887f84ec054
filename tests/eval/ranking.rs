//! AUPRC and F1.

use limpid::offline::eval::ranking::suspicion;
use limpid::offline::eval::{Decision, Ranking};
use serde::Deserialize;

#[derive(Deserialize)]
struct Case {
    name: String,
    scores: Vec<f32>,
    bad: Vec<u8>,
    auprc: f64,
    best_f1: f64,
}

fn ranking(scores: &[f32], bad: &[u8]) -> Ranking {
    let mut ranking = Ranking::default();
    for (&score, &bad) in scores.iter().zip(bad) {
        ranking.put(score, bad == 1);
    }
    ranking
}

fn cases() -> Vec<Case> {
    let text = std::fs::read_to_string("testdata/reference/ranking.json").unwrap();
    let cases: Vec<Case> = serde_json::from_str(&text).unwrap();
    assert_eq!(cases.len(), 6);
    cases
}

/// Scores that share their first 16 bits become ties; others are exact.
const TIES: f64 = 0.004;

#[test]
fn figures_are_scikit_learns() {
    for case in cases() {
        let ranking = ranking(&case.scores, &case.bad);
        let tolerance = if case.name.contains("ties") { 1e-12 } else { TIES };
        let (auprc, best_f1) = (ranking.auprc().unwrap(), ranking.best_f1().unwrap());
        assert!((auprc - case.auprc).abs() < tolerance, "{}: {auprc} for {}", case.name, case.auprc);
        assert!((best_f1 - case.best_f1).abs() < tolerance, "{}: {best_f1} for {}", case.name, case.best_f1);
    }
}

#[test]
fn the_comparison_can_fail() {
    for case in cases() {
        // The labels of neighbours swapped: a different ranking.
        let swapped: Vec<u8> = case.bad.chunks(2).flat_map(|pair| pair.iter().rev().copied()).collect();
        let reversed: Vec<f32> = case.scores.iter().map(|score| -score).collect();
        let changed = [ranking(&case.scores, &swapped).auprc(), ranking(&reversed, &case.bad).auprc()];
        let far = |auprc: &Option<f64>| (auprc.unwrap() - case.auprc).abs() > 2.0 * TIES;
        assert!(changed.iter().any(far), "{}: {changed:?} for {}", case.name, case.auprc);
    }
}

#[test]
fn by_hand() {
    // From the top: bad (precision 1), good, bad (2/3), good: AP = 0.5 * 1 + 0.5 * 2/3; F1 best 0.8 at three called.
    let four = ranking(&[4.0, 3.0, 2.0, 1.0], &[1, 0, 1, 0]);
    assert!((four.auprc().unwrap() - (0.5 + 1.0 / 3.0)).abs() < 1e-12);
    assert!((four.best_f1().unwrap() - 0.8).abs() < 1e-12);
    assert_eq!(four.base_rate(), Some(0.5));
    // All tied: precision is the base rate.
    let tied = ranking(&[1.0; 4], &[1, 0, 0, 0]);
    assert_eq!((tied.auprc(), tied.base_rate()), (Some(0.25), Some(0.25)));
    // Nothing bad, nothing at all: no figure.
    assert_eq!(ranking(&[1.0, 2.0], &[0, 0]).auprc(), None);
    assert_eq!(ranking(&[1.0, 2.0], &[0, 0]).best_f1(), None);
    assert_eq!(Ranking::default().base_rate(), None);
}

#[test]
fn scores_of_any_kind_are_in_order() {
    let ascending =
        [f32::NEG_INFINITY, -1e30, -2.0, -1e-30, 0.0, 1e-40, 1e-30, 0.5, 2.0, 1e30, f32::INFINITY];
    for pair in ascending.windows(2) {
        let auprc = ranking(pair, &[0, 1]).auprc().unwrap();
        // Denormals may tie with 0.
        let tied = pair[0] == 0.0 || pair[1] == 0.0 || pair[1] == 1e-30;
        assert!(auprc == 1.0 || (tied && auprc == 0.5), "{pair:?}: {auprc}");
    }
    assert_eq!(ranking(&[-0.0, 0.0], &[0, 1]).auprc(), Some(0.5), "both zeros are one");
    assert_eq!(ranking(&[f32::NAN, 1e30], &[1, 0]).auprc(), Some(1.0), "NaN is as suspicious as can be");
    let scores = [0.0, 1e-6, 0.3, 0.999_999, 1.0].map(suspicion);
    assert!(scores.windows(2).all(|pair| pair[0] > pair[1]), "{scores:?}");
}

#[test]
fn counts_add_up_and_survive_json() {
    let case = &cases()[1];
    let half = case.scores.len() / 2;
    let mut sum = ranking(&case.scores[..half], &case.bad[..half]);
    sum.add(&ranking(&case.scores[half..], &case.bad[half..]));
    let whole = ranking(&case.scores, &case.bad);
    assert_eq!(sum, whole);
    let text = serde_json::to_string(&whole).unwrap();
    assert!(text.len() < 20_000, "{} bytes", text.len());
    assert_eq!(serde_json::from_str::<Ranking>(&text).unwrap(), whole);
}

#[test]
fn decisions_by_hand() {
    let mut decision = Decision::default();
    assert_eq!(decision.f1(), None);
    for (called, bad) in [(true, true), (true, true), (true, false), (false, true), (false, false)] {
        decision.put(called, bad);
    }
    // Precision 2/3, recall 2/3.
    assert_eq!(decision, Decision { hits: 2, false_alarms: 1, misses: 1 });
    assert!((decision.f1().unwrap() - 2.0 / 3.0).abs() < 1e-12);
}
