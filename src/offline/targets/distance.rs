//! How far reference depth is from the true depth.

use crate::offline::targets::sample::Sample;
use crate::sim::material::Kind;

/// Counts over the network's pixels of samples.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Counts {
    /// Pixels; of samples with truth only those with true depth.
    pub pixels: u64,
    /// Of these, those with a reference.
    pub covered: u64,
    /// Of these, those whose reference is wrong by more than delta of the true depth.
    pub wrong: u64,
    /// Sum of their squared errors, square metres.
    pub squared_error_m2: f64,
    /// Covered pixels with depth.
    pub judged: u64,
    /// Of these, good ones (by true depth) that the reference calls bad.
    pub good_called_bad: u64,
    /// Bad ones that it calls good.
    pub bad_called_good: u64,
}

impl Counts {
    fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.covered += other.covered;
        self.wrong += other.wrong;
        self.squared_error_m2 += other.squared_error_m2;
        self.judged += other.judged;
        self.good_called_bad += other.good_called_bad;
        self.bad_called_good += other.bad_called_good;
    }
}

/// All pixels together, and apart by kind of surface (those kinds that mirror or transmit, and the rest).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Distance {
    /// Whether any sample had truth.
    pub truth: bool,
    /// All.
    pub all: Counts,
    /// Matt surfaces.
    pub matt: Counts,
    /// Under a clear coat that reflects.
    pub glossy: Counts,
    /// Panes.
    pub glass: Counts,
    /// Mirrors and metal.
    pub mirror: Counts,
}

impl Distance {
    /// Adds the counts of another recording.
    pub fn merge(&mut self, other: &Self) {
        self.truth |= other.truth;
        self.all.add(&other.all);
        self.matt.add(&other.matt);
        self.glossy.add(&other.glossy);
        self.glass.add(&other.glass);
        self.mirror.add(&other.mirror);
    }

    /// Counts the pixels of one more sample.
    pub fn add(&mut self, sample: &Sample) {
        self.truth |= sample.truth.is_some();
        for pixel in 0..sample.depth_m.len() {
            let (counts, kind) = counts(sample, pixel);
            self.all.add(&counts);
            let group = match kind {
                Some(Kind::Glossy) => Some(&mut self.glossy),
                Some(Kind::Glass) => Some(&mut self.glass),
                Some(Kind::Mirror | Kind::Metal) => Some(&mut self.mirror),
                Some(_) => Some(&mut self.matt),
                None => None,
            };
            if let Some(group) = group {
                group.add(&counts);
            }
        }
    }
}

fn counts(sample: &Sample, pixel: usize) -> (Counts, Option<Kind>) {
    let reference = sample.measured.reference_m[pixel];
    let mut counts = Counts { pixels: 1, covered: u64::from(reference > 0.0), ..Counts::default() };
    let Some((truth, kinds)) = &sample.truth else { return (counts, None) };
    let true_m = truth.reference_m[pixel];
    if true_m <= 0.0 {
        return (Counts::default(), None);
    }
    if reference > 0.0 {
        let error_m = f64::from(reference - true_m);
        counts.wrong = u64::from(error_m.abs() > f64::from(sample.tolerance_m[pixel]));
        counts.squared_error_m2 = error_m * error_m;
        if sample.depth_m[pixel] > 0.0 {
            counts.judged = 1;
            let [good, called] = [&truth.binary, &sample.measured.binary].map(|b| b[pixel] > 0.5);
            counts.good_called_bad = u64::from(good && !called);
            counts.bad_called_good = u64::from(!good && called);
        }
    }
    (counts, Kind::of_code(kinds[pixel]))
}

fn percent(part: u64, whole: u64) -> f64 {
    #[expect(clippy::cast_precision_loss, reason = "pixels of any recording fit in 53 bits")]
    let share = part as f64 / whole.max(1) as f64;
    100.0 * share
}

impl std::fmt::Display for Distance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if !self.truth {
            return write!(f, "reference covers {:.1} %", percent(self.all.covered, self.all.pixels));
        }
        let rows = [
            ("all", self.all),
            ("matt", self.matt),
            ("glossy", self.glossy),
            ("glass", self.glass),
            ("mirror", self.mirror),
        ];
        writeln!(f, "surface   pixels  covered  RMSE m   wrong  good called bad  bad called good")?;
        for (name, c) in rows.into_iter().filter(|(_, counts)| counts.pixels > 0) {
            #[expect(clippy::cast_precision_loss, reason = "pixels of any recording fit in 53 bits")]
            let rmse_m = (c.squared_error_m2 / c.covered.max(1) as f64).sqrt();
            writeln!(
                f,
                "{name:7} {:8} {:6.1} % {rmse_m:7.3} {:5.1} % {:14.2} % {:14.2} %",
                c.pixels,
                percent(c.covered, c.pixels),
                percent(c.wrong, c.covered),
                percent(c.good_called_bad, c.judged),
                percent(c.bad_called_good, c.judged),
            )?;
        }
        Ok(())
    }
}
