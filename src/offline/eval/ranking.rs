//! How well a score finds bad pixels among good ones: average precision (AUPRC) and F1.

use serde::{Deserialize, Serialize};

use crate::offline::eval::share;

/// Bits of a score that are kept: sign, exponent and 7 of the mantissa, so scores closer than 0.8 % are ties.
const KEPT_BITS: u32 = 16;

/// Counts of good and bad pixels by score, so that those of many frames add up and nothing has to be sorted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(from = "Sparse", into = "Sparse")]
pub struct Ranking {
    /// Good and bad by the score's bin, the least suspicious first.
    bins: Vec<[u64; 2]>,
}

/// Bin, good, bad.
type Sparse = Vec<(u16, u64, u64)>;

impl Default for Ranking {
    fn default() -> Self {
        Self { bins: vec![[0, 0]; 1 << KEPT_BITS] }
    }
}

impl From<Sparse> for Ranking {
    fn from(sparse: Sparse) -> Self {
        let mut ranking = Self::default();
        for (bin, good, bad) in sparse {
            ranking.bins[usize::from(bin)] = [good, bad];
        }
        ranking
    }
}

impl From<Ranking> for Sparse {
    fn from(ranking: Ranking) -> Self {
        let filled = (0..=u16::MAX).zip(ranking.bins).filter(|(_, counts)| *counts != [0, 0]);
        filled.map(|(bin, [good, bad])| (bin, good, bad)).collect()
    }
}

/// Bins in the order of the scores; NaN is as suspicious as can be.
fn bin(score: f32) -> usize {
    // Adding 0 turns -0 into 0.
    let bits = if score.is_nan() { f32::INFINITY } else { score + 0.0 }.to_bits();
    let ordered = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
    (ordered >> (32 - KEPT_BITS)) as usize
}

/// The score of a reliability in [0, 1]: the odds that it is wrong, which keeps both ends of the range apart.
pub fn suspicion(reliability: f32) -> f32 {
    (1.0 - reliability) / reliability.max(f32::MIN_POSITIVE)
}

impl Ranking {
    /// Counts a pixel; a higher `score` calls it more suspicious.
    pub fn put(&mut self, score: f32, is_bad: bool) {
        self.bins[bin(score)][usize::from(is_bad)] += 1;
    }

    /// Adds the counts of another.
    pub fn add(&mut self, other: &Self) {
        for (mine, theirs) in self.bins.iter_mut().zip(&other.bins) {
            mine[0] += theirs[0];
            mine[1] += theirs[1];
        }
    }

    /// Pixels, good and bad.
    pub fn counts(&self) -> [u64; 2] {
        self.bins.iter().fold([0, 0], |sum, bin| [sum[0] + bin[0], sum[1] + bin[1]])
    }

    /// Share of bad pixels, which is the AUPRC of a score that says nothing.
    pub fn base_rate(&self) -> Option<f64> {
        let [good, bad] = self.counts();
        share(bad, good + bad)
    }

    /// Good and bad pixels at least as suspicious as each threshold, from the highest down.
    fn called(&self) -> impl Iterator<Item = [u64; 2]> + '_ {
        let filled = self.bins.iter().rev().filter(|counts| **counts != [0, 0]);
        filled.scan([0, 0], |sum, counts| {
            *sum = [sum[0] + counts[0], sum[1] + counts[1]];
            Some(*sum)
        })
    }

    /// Area under the precision-recall curve as average precision: the sum over thresholds of the step in recall times the
    /// precision there (scikit-learn's `average_precision_score`). `None` without bad pixels.
    pub fn auprc(&self) -> Option<f64> {
        let [_, all_bad] = self.counts();
        let mut before = 0;
        let mut area = 0.0;
        for [good, bad] in self.called() {
            area += share(bad - before, all_bad)? * share(bad, good + bad)?;
            before = bad;
        }
        (all_bad > 0).then_some(area)
    }

    /// The best F1 over all thresholds. `None` without bad pixels.
    pub fn best_f1(&self) -> Option<f64> {
        let [_, all_bad] = self.counts();
        let f1 =
            |[good, bad]: [u64; 2]| Decision { hits: bad, false_alarms: good, misses: all_bad - bad }.f1();
        self.called().filter_map(f1).reduce(f64::max).filter(|_| all_bad > 0)
    }
}

/// What one threshold decides: bad pixels called bad, good ones called bad, bad ones called good.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Decision {
    /// Bad, called bad.
    pub hits: u64,
    /// Good, called bad.
    pub false_alarms: u64,
    /// Bad, called good.
    pub misses: u64,
}

impl Decision {
    /// Counts a pixel.
    pub fn put(&mut self, called_bad: bool, is_bad: bool) {
        match (called_bad, is_bad) {
            (true, true) => self.hits += 1,
            (true, false) => self.false_alarms += 1,
            (false, true) => self.misses += 1,
            (false, false) => {}
        }
    }

    /// Adds the counts of another.
    pub fn add(&mut self, other: &Self) {
        self.hits += other.hits;
        self.false_alarms += other.false_alarms;
        self.misses += other.misses;
    }

    /// Harmonic mean of precision and recall. `None` where nothing is bad and nothing is called so.
    pub fn f1(&self) -> Option<f64> {
        share(2 * self.hits, 2 * self.hits + self.false_alarms + self.misses)
    }
}
