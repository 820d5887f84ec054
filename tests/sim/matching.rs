//! Census, costs and winners against plain twins.

use limpid::gpu::Invocations;
use limpid::sim::passes::{
    CENSUS, COST, DEPTH, SimCensusParams, SimCostParams, SimDepthParams, SimWinnerParams, WINNER,
};

use crate::support::compare::{EXACT, Tolerance, assert_close};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

const FIT: Tolerance = Tolerance { absolute: 1e-4, reason: "one division in single precision" };

fn packed(grey: &[u8]) -> Vec<u32> {
    grey.chunks_exact(4).map(|four| u32::from_le_bytes(four.try_into().unwrap())).collect()
}

fn random_grey(width: usize, height: usize, seed: u64) -> Vec<u8> {
    let mut random = Random(seed);
    (0..width * height).map(|_| random.below(256) as u8).collect()
}

/// Neighbours darker than the pixel, by (row, column); columns beyond the border repeat the border's word of four.
fn census_twin(width: usize, height: usize, grey: &[u8]) -> (Vec<Vec<bool>>, Vec<f64>) {
    let (w, h) = (width as i64, height as i64);
    let value = |x: i64, y: i64| {
        let x = if x < 0 {
            x + 4
        } else if x >= w {
            x - 4
        } else {
            x
        };
        grey[(y.clamp(0, h - 1) * w + x) as usize]
    };
    let (mut bits, mut deviations) = (Vec::new(), Vec::new());
    for y in 0..h {
        for x in 0..w {
            let center = value(x, y);
            let window: Vec<_> = (-3..=3).flat_map(|dy| (-4..=4).map(move |dx| (dx, dy))).collect();
            bits.push(window.iter().map(|&(dx, dy)| value(x + dx, y + dy) < center).collect());
            let values: Vec<f64> = window.iter().map(|&(dx, dy)| f64::from(value(x + dx, y + dy))).collect();
            let mean = values.iter().sum::<f64>() / 63.0;
            deviations.push((values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 63.0).sqrt());
        }
    }
    (bits, deviations)
}

fn signatures(width: usize, height: usize, grey: &[u8]) -> (Vec<u32>, Vec<f32>) {
    let params = SimCensusParams { words: width as u32 / 4, height: height as u32 };
    let out = Fragment::new()
        .params("census_params", &params)
        .input("grey", &packed(grey))
        .output("signature", 2 * width * height)
        .output("texture", width * height)
        .run(CENSUS, Invocations::area(width as u32 / 4, height as u32));
    (out.words("signature").to_vec(), out.floats("texture"))
}

fn hamming(a: &[bool], b: &[bool]) -> u32 {
    a.iter().zip(b).map(|(a, b)| u32::from(a != b)).sum()
}

#[test]
fn twin_of_census_at_edge_sizes() {
    if skipped() {
        return;
    }
    for (width, height) in [(8, 1), (16, 3), (64, 4), (72, 9)] {
        let grey = random_grey(width, height, 3);
        let (bits, deviations) = census_twin(width, height, &grey);
        let (words, texture) = signatures(width, height, &grey);
        // Distances are what matters; the order of bits is the shader's own.
        let pairs: Vec<_> = (0..width * height).map(|i| (i, (i * 7 + 5) % (width * height))).collect();
        let got: Vec<u32> = pairs
            .iter()
            .map(|&(i, j)| (0..2).map(|k| (words[2 * i + k] ^ words[2 * j + k]).count_ones()).sum())
            .collect();
        let want: Vec<u32> = pairs.iter().map(|&(i, j)| hamming(&bits[i], &bits[j])).collect();
        assert_close("distances", &got, &want, EXACT);
        let rounded = Tolerance { absolute: 0.01, reason: "squares of 63 levels in single precision" };
        assert_close("texture", &texture, &deviations, rounded);
    }
    let (words, texture) = signatures(16, 4, &[77; 64]);
    assert!(words.iter().all(|&word| word == 0) && texture.iter().all(|&t| t == 0.0), "flat");
}

/// Costs by row, disparity and column, each over five columns; columns beyond a border repeat it.
fn costs_twin(width: usize, height: usize, disparities: usize, left: &[u32], right: &[u32]) -> Vec<u32> {
    let clamp = |x: i64| x.clamp(0, width as i64 - 1) as usize;
    let mut costs = Vec::new();
    for y in 0..height {
        for d in 0..disparities as i64 {
            for x in 0..width as i64 {
                let at = |row: &[u32], x: usize| [row[2 * (y * width + x)], row[2 * (y * width + x) + 1]];
                let column = |c: i64| {
                    let (a, b) = (at(left, clamp(c)), at(right, clamp(c - d)));
                    (a[0] ^ b[0]).count_ones() + (a[1] ^ b[1]).count_ones()
                };
                costs.push((x - 2..=x + 2).map(column).sum());
            }
        }
    }
    costs
}

/// The shader's volume: rows, eight columns, words of two disparities.
fn volume_of(costs: &[u32], width: usize, height: usize, disparities: usize) -> Vec<u32> {
    let cost = |y: usize, d: usize, x: usize| costs[(y * disparities + d) * width + x];
    let mut volume = Vec::new();
    for y in 0..height {
        for tile in 0..width / 8 {
            for word in 0..disparities / 2 {
                let at = |x: usize| cost(y, 2 * word, x) | (cost(y, 2 * word + 1, x) << 16);
                volume.extend((0..8).map(|x| at(tile * 8 + x)));
            }
        }
    }
    volume
}

#[test]
fn twin_of_costs_at_edge_sizes() {
    if skipped() {
        return;
    }
    for (width, height, disparities) in [(8, 1, 8), (16, 9, 16), (72, 3, 24)] {
        let mut random = Random(11);
        let mut row =
            || (0..2 * width * height).map(|_| random.next() as u32 & 0x7fff_ffff).collect::<Vec<_>>();
        let (left, right) = (row(), row());
        let words = disparities / 2;
        let params =
            SimCostParams { width: width as u32, height: height as u32, disparity_words: words as u32 };
        let out = Fragment::new()
            .params("cost_params", &params)
            .input("left_signature", &left)
            .input("right_signature", &right)
            .output("volume", width * height * words)
            .run(COST, Invocations([width as u32 / 8, height as u32, words as u32 / 4]));
        let costs = costs_twin(width, height, disparities, &left, &right);
        assert_close("costs", out.words("volume"), &volume_of(&costs, width, height, disparities), EXACT);
    }
}

/// Disparity of each pixel of the left image or the right one, over five rows; -1: none.
fn winners_twin(costs: &[u32], width: usize, height: usize, disparities: usize, left: bool) -> Vec<f64> {
    let mut found = Vec::new();
    for y in 0..height as i64 {
        for x in 0..width {
            let row = |r: i64| r.clamp(0, height as i64 - 1) as usize;
            let cost = |d: usize| -> u32 {
                let from = if left { x } else { x + d };
                let at = |r: i64| costs[(row(r) * disparities + d) * width + from];
                (y - 2..=y + 2).map(|r| if from < width { at(r) } else { 310 }).sum()
            };
            let sums: Vec<u32> = (0..disparities).map(cost).collect();
            let best = (0..disparities).min_by_key(|&d| (sums[d], d)).unwrap();
            let others = (0..disparities).filter(|d| d.abs_diff(best) > 1).map(|d| sums[d]);
            let second = others.min().unwrap_or(65535);
            let sure = !left || f64::from(sums[best]) < 0.9 * f64::from(second) && sums[best] <= 700;
            let mut fit = best as f64;
            if left && best > 0 && best + 1 < disparities {
                let [a, c, b] = [best - 1, best, best + 1].map(|d| f64::from(sums[d]));
                fit += 0.5 * (a - b) / (a.max(b) - c).max(1.0);
            }
            found.push(if sure { fit } else { -1.0 });
        }
    }
    found
}

#[test]
fn twin_of_winners_at_edge_sizes() {
    if skipped() {
        return;
    }
    for (width, height, disparities, seed) in [(8, 1, 8, 1), (16, 4, 8, 2), (64, 5, 16, 3), (72, 11, 24, 4)] {
        let mut random = Random(seed);
        let costs: Vec<u32> = (0..width * height * disparities).map(|_| random.below(60) + 100).collect();
        let params = SimWinnerParams {
            width: width as u32,
            height: height as u32,
            disparity_words: disparities as u32 / 2,
            uniqueness: 0.1,
            largest_cost: 700.0,
        };
        let volume = volume_of(&costs, width, height, disparities);
        for left in [true, false] {
            let out = Fragment::new()
                .params("winner_params", &params)
                .constants(&[("left", left)])
                .input("volume", &volume)
                .output("disparity", width * height)
                .run(WINNER, Invocations::area(width as u32, height.div_ceil(4) as u32));
            let want = winners_twin(&costs, width, height, disparities, left);
            assert_close("disparities", &out.floats("disparity"), &want, FIT);
            let (some, none) = (want.iter().any(|&d| d > 0.0), want.contains(&-1.0));
            assert!(seed != 4 || (some && none == left), "both kinds are tested");
        }
    }
}

#[test]
fn truth_of_the_checks_on_depth() {
    if skipped() {
        return;
    }
    // Pixel 5 meets 4, which matches elsewhere; 3 is ambiguous; 6 lacks texture; 0 is matched outside the image.
    let left = [2.0_f32, 0.5, 1.0, -1.0, 2.0, 1.0, 1.0, 3.0];
    let right = [0.4_f32, 1.5, 2.9, 0.0, 3.0, 1.0, 0.0, 0.0];
    let texture = [5.0_f32, 5.0, 5.0, 5.0, 5.0, 5.0, 0.1, 5.0];
    let params = SimDepthParams {
        width: 8,
        height: 1,
        focal_baseline_mm: 3000.0,
        left_right_px: 1.0,
        texture: 0.8,
        step_px: 0.25,
        largest_px: 7.0,
        pad0: 0,
    };
    let depth = Fragment::new()
        .params("depth_params", &params)
        .input("left_disparity", &left)
        .input("right_disparity", &right)
        .input("texture", &texture)
        .output("depth_mm", 8)
        .run(DEPTH, Invocations::line(8));
    assert_close("depth", depth.words("depth_mm"), &[0_u32, 6000, 3000, 0, 1500, 0, 0, 1000], EXACT);
}
