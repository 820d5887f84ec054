//! The echoes of a beam against a plain twin.

use limpid::gpu::Invocations;
use limpid::sim::passes::{ECHO, SimEchoParams};

use crate::support::gpu::{Fragment, Outputs, skipped};
use crate::support::random::Random;

const SUBRAYS: u32 = 8;

fn params(beams: u32, returns: u32) -> SimEchoParams {
    SimEchoParams {
        beams,
        subrays: SUBRAYS,
        returns,
        calibrated: 1,
        seed: 5,
        threshold: 0.01,
        pulse_m: 1.0,
        range_noise_m: 0.0,
        power_noise: 0.0,
        scale: 100.0,
        largest: 255.0,
        nearest_m: 0.5,
        focus_m: 0.0,
        pad0: 0,
        pad1: 0,
        pad2: 0,
    }
}

fn run(params: &SimEchoParams, parts: &[[u32; 4]]) -> Outputs {
    Fragment::new()
        .params("echo_params", params)
        .input("sent_back", parts)
        .output("echoes", 8 * params.beams as usize)
        .run(ECHO, Invocations::line(params.beams))
}

/// A part: range, power (of its sub-ray), mark.
fn part(range_m: f32, power: f32, mark: u32) -> [u32; 4] {
    [range_m.to_bits(), power.to_bits(), mark, 7 * mark]
}

/// Range, power and mark of the peaks, the strongest first.
fn peaks(params: &SimEchoParams, parts: &[[u32; 4]]) -> Vec<(f32, f32, u32)> {
    let mut left: Vec<(f32, f32, u32)> = parts
        .iter()
        .map(|p| (f32::from_bits(p[0]), f32::from_bits(p[1]) / SUBRAYS as f32, p[2]))
        .filter(|p| p.1 > 0.0 && p.0 >= params.nearest_m)
        .collect();
    left.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut peaks = Vec::new();
    while peaks.len() < 4 {
        let window = |first: usize| {
            let end = left[first].0 + params.pulse_m;
            let inside = left[first..].iter().take_while(|p| p.0 <= end);
            inside.copied().collect::<Vec<_>>()
        };
        let power = |parts: &[(f32, f32, u32)]| parts.iter().map(|p| f64::from(p.1)).sum::<f64>();
        let windows = (0..left.len()).map(window);
        let Some(best) = windows.reduce(|a, b| if power(&b) > power(&a) * (1.0 + 1e-6) { b } else { a })
        else {
            break;
        };
        if power(&best) < f64::from(params.threshold) {
            break;
        }
        let sum = power(&best);
        let range = best.iter().map(|p| f64::from(p.0) * f64::from(p.1)).sum::<f64>() / sum;
        let strongest = best.iter().fold(best[0], |a, &b| if b.1 > a.1 { b } else { a });
        peaks.push((range as f32, sum as f32, strongest.2));
        left.iter_mut()
            .filter(|p| (f64::from(p.0) - range).abs() < params.pulse_m.into())
            .for_each(|p| p.1 = 0.0);
        left.retain(|p| p.1 > 0.0);
    }
    peaks
}

#[test]
fn twin_of_random_parts_in_every_mode() {
    if skipped() {
        return;
    }
    let mut random = Random(11);
    let beams = 65;
    // Ranges by quarters of a metre, powers by eighths: no two windows are nearly as strong.
    let parts: Vec<[u32; 4]> = (0..beams * 4 * SUBRAYS)
        .map(|i| {
            let range = 0.25 * random.below(60) as f32 + 0.01 * random.unit();
            let power = if random.below(3) == 0 { 0.2 * random.unit() } else { 0.0 };
            part(range, power, i + 1)
        })
        .collect();
    let mut twice = 0;
    for returns in 0..3 {
        let params = params(beams, returns);
        let out = run(&params, &parts);
        let slots: Vec<&[u32]> = out.words("echoes").chunks_exact(4).collect();
        for (beam, own) in parts.chunks_exact(4 * SUBRAYS as usize).enumerate() {
            let peaks = peaks(&params, own);
            let by = |a: &(f32, f32, u32), b: &(f32, f32, u32)| a.0.total_cmp(&b.0);
            let (first, last) = (peaks.iter().copied().min_by(by), peaks.iter().copied().max_by(by));
            let want = match (returns, peaks.len()) {
                (_, 0) => [None, None],
                (0, _) | (_, 1) => [Some(peaks[0]), None],
                (1, _) if last == Some(peaks[0]) => [last, Some(peaks[1])],
                (1, _) => [last, Some(peaks[0])],
                _ => [last, first],
            };
            twice += u32::from(want[1].is_some());
            for (slot, want) in slots[2 * beam..2 * beam + 2].iter().zip(want) {
                let got = (f32::from_bits(slot[0]), f32::from_bits(slot[1]), slot[2]);
                let want =
                    want.map_or((0.0, 0.0, 0), |(r, p, mark)| (r, (p * r * r * 100.0).min(255.0), mark));
                let close = (got.0 - want.0).abs() < 1e-3 && (got.1 - want.1).abs() < 0.02 + 1e-3 * want.1;
                assert!(close && got.2 == want.2, "beam {beam}, returns {returns}: {got:?} for {want:?}");
                assert_eq!(slot[3], 7 * want.2);
            }
        }
    }
    assert!(twice > 60, "{twice}");
}

#[test]
fn beams_without_power_and_beyond_the_last_give_nothing() {
    if skipped() {
        return;
    }
    for beams in [1, 63, 64, 65] {
        let silent = vec![part(5.0, 0.0, 3); (beams * 4 * SUBRAYS) as usize];
        let out = run(&params(beams, 1), &silent);
        assert!(out.words("echoes").iter().all(|&word| word == 0), "{beams}");
        let faint = vec![part(5.0, 0.0009, 3); (beams * 4 * SUBRAYS) as usize];
        assert!(run(&params(beams, 1), &faint).words("echoes").iter().all(|&word| word == 0), "{beams}");
    }
    Fragment::new()
        .params("echo_params", &params(1, 0))
        .input("sent_back", &[[0_u32; 4]; 32])
        .output("echoes", 8)
        .refuses_nothing(ECHO);
}

#[test]
fn poisoned_parts_are_no_echoes() {
    if skipped() {
        return;
    }
    let own = (4 * SUBRAYS) as usize;
    let mut parts = vec![part(4.0, 0.5, 9); own];
    parts[0] = [f32::NAN.to_bits(), 0.5_f32.to_bits(), 1, 1];
    parts[1] = [4.0_f32.to_bits(), f32::NAN.to_bits(), 1, 1];
    parts[2] = [f32::NEG_INFINITY.to_bits(), 0.5_f32.to_bits(), 1, 1];
    parts[3] = part(0.1, 50.0, 1);
    let out = run(&params(1, 1), &parts);
    assert!((f32::from_bits(out.words("echoes")[0]) - 4.0).abs() < 1e-5);
    assert_eq!(out.words("echoes")[2], 9);
    assert_eq!(out.words("echoes")[4], 0, "nothing nearer than the sensor sees");
}
