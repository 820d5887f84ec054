//! Cheap predictors of bad depth, from the depth image alone, that a network has to beat (spec 1 §8).

use std::f32::consts::SQRT_2;

/// Half the window of the local variance, pixels.
const REACH: usize = 2;

/// A predictor: higher is more suspicious.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Predictor {
    /// Depth itself.
    Depth,
    /// Largest difference to a measured neighbour (left, right, above, below).
    Gradient,
    /// Variance of the measured depths in 5x5.
    Variance,
    /// Nearness of the nearest hole: 1 / distance in pixels (steps of 1 and sqrt 2).
    HoleNearness,
}

impl Predictor {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Depth, Self::Gradient, Self::Variance, Self::HoleNearness];

    /// Its name in reports.
    pub fn key(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::Gradient => "gradient",
            Self::Variance => "variance",
            Self::HoleNearness => "hole_nearness",
        }
    }

    /// Its score at every pixel of a depth image in metres, 0 being a hole; the scores of holes mean nothing.
    pub fn scores(self, depth_m: &[f32], width: usize) -> Vec<f32> {
        if width == 0 || depth_m.is_empty() {
            return Vec::new();
        }
        match self {
            Self::Depth => depth_m.to_vec(),
            Self::Gradient => gradient(depth_m, width),
            Self::Variance => variance(depth_m, width),
            Self::HoleNearness => hole_nearness(depth_m, width),
        }
    }
}

fn gradient(depth_m: &[f32], width: usize) -> Vec<f32> {
    let height = depth_m.len() / width;
    let mut scores = vec![0.0_f32; depth_m.len()];
    let mut pair = |a: usize, b: usize| {
        if depth_m[a] > 0.0 && depth_m[b] > 0.0 {
            let step = (depth_m[a] - depth_m[b]).abs();
            scores[a] = scores[a].max(step);
            scores[b] = scores[b].max(step);
        }
    };
    for y in 0..height {
        for x in 0..width {
            let here = y * width + x;
            if x + 1 < width {
                pair(here, here + 1);
            }
            if y + 1 < height {
                pair(here, here + width);
            }
        }
    }
    scores
}

/// Number, sum and sum of squares of depths.
type Moments = [f64; 3];

fn plus(a: Moments, b: Moments, sign: f64) -> Moments {
    [a[0] + sign * b[0], a[1] + sign * b[1], a[2] + sign * b[2]]
}

/// Sums of `values[i - REACH ..= i + REACH]` with a stride, cut at the borders.
fn sliding(values: &[Moments], start: usize, stride: usize, count: usize, out: &mut [Moments]) {
    let at = |i: usize| values[start + i * stride];
    let mut sum = [0.0; 3];
    for i in 0..REACH.min(count) {
        sum = plus(sum, at(i), 1.0);
    }
    for i in 0..count {
        if i + REACH < count {
            sum = plus(sum, at(i + REACH), 1.0);
        }
        if i > REACH {
            sum = plus(sum, at(i - REACH - 1), -1.0);
        }
        out[start + i * stride] = sum;
    }
}

fn variance(depth_m: &[f32], width: usize) -> Vec<f32> {
    let height = depth_m.len() / width;
    let moments = |&d: &f32| {
        let depth = f64::from(d);
        if d > 0.0 { [1.0, depth, depth * depth] } else { [0.0; 3] }
    };
    let values: Vec<Moments> = depth_m.iter().map(moments).collect();
    let (mut rows, mut all) = (values.clone(), values.clone());
    for y in 0..height {
        sliding(&values, y * width, 1, width, &mut rows);
    }
    for x in 0..width {
        sliding(&rows, x, width, height, &mut all);
    }
    let variance = |&[count, sum, squares]: &Moments| {
        let mean = sum / count.max(1.0);
        crate::stage::single((squares / count.max(1.0) - mean * mean).max(0.0))
    };
    all.iter().map(variance).collect()
}

fn hole_nearness(depth_m: &[f32], width: usize) -> Vec<f32> {
    let height = depth_m.len() / width;
    let mut distance: Vec<f32> = depth_m.iter().map(|&d| if d > 0.0 { f32::INFINITY } else { 0.0 }).collect();
    // Half the neighbours on the way down, the other half on the way up.
    for y in 0..height {
        for x in 0..width {
            relax(&mut distance, width, [x, y], [y > 0, false]);
        }
        for x in (0..width).rev() {
            relax(&mut distance, width, [x, y], [false, false]);
        }
    }
    for y in (0..height).rev() {
        for x in 0..width {
            relax(&mut distance, width, [x, y], [false, y + 1 < height]);
        }
        for x in (0..width).rev() {
            relax(&mut distance, width, [x, y], [false, false]);
        }
    }
    distance.iter().map(|&d| if d > 0.0 { 1.0 / d } else { f32::INFINITY }).collect()
}

/// Shortens the distance of a pixel by way of its neighbours in its row, and above or below where asked for.
fn relax(distance: &mut [f32], width: usize, [x, y]: [usize; 2], [above, below]: [bool; 2]) {
    let here = y * width + x;
    let mut best = distance[here];
    let mut by = |from: usize, step: f32| best = best.min(distance[from] + step);
    let rows = [
        (true, here, 1.0, 0.0),
        (above, here.wrapping_sub(width), SQRT_2, 1.0),
        (below, here + width, SQRT_2, 1.0),
    ];
    for (wanted, middle, aside, straight) in rows {
        if !wanted {
            continue;
        }
        by(middle, straight);
        if x > 0 {
            by(middle - 1, aside);
        }
        if x + 1 < width {
            by(middle + 1, aside);
        }
    }
    distance[here] = best;
}
