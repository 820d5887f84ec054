//! The ground among the samples of a message (spec 6 §2), in plain words and f64.

use std::collections::BTreeSet;

use glam::{DVec2, DVec3};

/// A sample: where it lies from the sensor, and how near a plane it is on it.
pub(crate) type Sample = (DVec3, f64);

/// z = x a + y b + c.
pub(crate) type Plane = DVec3;

const SQUARES: i64 = 64;

/// The sample of what lies at `place`; `None`: it is none.
pub(crate) fn sample(place: DVec3) -> Option<Sample> {
    let tolerance = 0.03 + 0.01 * place.length();
    let below = place.z < -f64::max(0.05, 2.0 * tolerance) && place.truncate().length() < 20.0;
    below.then_some((place, tolerance))
}

pub(crate) fn height_at(plane: Plane, at: DVec2) -> f64 {
    plane.truncate().dot(at) + plane.z
}

fn off(plane: Plane, sample: &Sample) -> f64 {
    sample.0.z - height_at(plane, sample.0.truncate())
}

/// How many samples lie on it.
pub(crate) fn score(plane: Plane, samples: &[Sample]) -> usize {
    // By the distance across, as planes that are drawn have a normal.
    let across = (1.0 + plane.truncate().length_squared()).sqrt();
    samples.iter().filter(|sample| off(plane, sample).abs() / across < sample.1).count()
}

/// Weighted least squares over the samples on it, five times and nearer each time; `pull` is the slope that few samples leave it at.
pub(crate) fn refit(mut plane: Plane, samples: &[Sample], pull: DVec2) -> Plane {
    for turn in 0..5 {
        let near = |sample: &&Sample| off(plane, sample).abs() < 0.75_f64.powi(turn) * sample.1;
        let on: Vec<_> = samples.iter().filter(near).collect();
        let weight = |sample: &Sample| sample.1.powi(-2);
        let total: f64 = on.iter().map(|sample| weight(sample)).sum();
        let mean = |of: &dyn Fn(&Sample) -> f64| {
            on.iter().map(|sample| weight(sample) * of(sample)).sum::<f64>() / total
        };
        let middle = DVec2::new(mean(&|s| s.0.x), mean(&|s| s.0.y));
        let lift = mean(&|s| off(plane, s));
        let from = |s: &Sample| s.0.truncate() - middle;
        let xx = mean(&|s| from(s).x * from(s).x) + 0.006;
        let xy = mean(&|s| from(s).x * from(s).y);
        let yy = mean(&|s| from(s).y * from(s).y) + 0.006;
        let back = 0.006 * (pull - plane.truncate());
        let x = mean(&|s| from(s).x * (off(plane, s) - lift)) + back.x;
        let y = mean(&|s| from(s).y * (off(plane, s) - lift)) + back.y;
        let turn = DVec2::new(yy * x - xy * y, xx * y - xy * x) / (xx * yy - xy * xy);
        plane += turn.extend(lift - turn.dot(middle));
    }
    plane
}

/// Squares of `square_m` that show the plane, and those where beams pass it beside what shows it.
pub(crate) fn squares(plane: Plane, samples: &[Sample], square_m: f64) -> [usize; 2] {
    let square = |at: DVec2| {
        let [x, y] = [at.x, at.y].map(|m| (m / square_m).floor() as i64 + SQUARES / 2);
        ((0..SQUARES).contains(&x) && (0..SQUARES).contains(&y)).then_some([x, y])
    };
    let on = samples.iter().filter(|sample| off(plane, sample).abs() < sample.1);
    let shown: BTreeSet<_> = on.filter_map(|sample| square(sample.0.truncate())).collect();
    let near = |[x, y]: [i64; 2]| (-1..=1).any(|i| (-1..=1).any(|j| shown.contains(&[x + i, y + j])));
    let deep = samples.iter().filter(|sample| off(plane, sample) < -f64::max(2.0 * sample.1, 0.1));
    let crossings = deep.map(|sample| {
        let height = off(plane, sample);
        sample.0.truncate() * (plane.z / (plane.z + height))
    });
    let pierced: BTreeSet<_> = crossings.filter_map(square).filter(|square| !near(*square)).collect();
    [shown.len(), pierced.len()]
}
