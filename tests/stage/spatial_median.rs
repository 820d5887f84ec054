//! 5x5 median of valid depths.

use limpid::gpu::Invocations;
use limpid::stage::camera::spatial_median::{SPATIAL_MEDIAN, SpatialMedianParams};

use crate::reference;
use crate::support::compare::{EXACT, assert_close};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

fn fragment(width: usize, height: usize, depth_m: &[f32]) -> Fragment {
    Fragment::new()
        .params("spatial_median_params", &SpatialMedianParams { width: width as u32, height: height as u32 })
        .input("depth_m", depth_m)
        .output("depth_median_m", width * height)
}

fn median(width: usize, height: usize, depth_m: &[f32]) -> Vec<f32> {
    let invocations = Invocations::area(width as u32, height as u32);
    fragment(width, height, depth_m).run(SPATIAL_MEDIAN, invocations).floats("depth_median_m")
}

fn noisy(width: usize, height: usize, holes: f32, seed: u64) -> Vec<f32> {
    let mut random = Random(seed);
    (0..width * height).map(|_| if random.chance(holes) { 0.0 } else { 0.2 + 9.0 * random.unit() }).collect()
}

#[test]
fn truth_spikes_vanish_and_holes_stay() {
    if skipped() {
        return;
    }
    let mut depth = vec![2.0; 9 * 9];
    depth[4 * 9 + 4] = 9.0;
    depth[2 * 9 + 6] = 0.3;
    depth[7 * 9 + 1] = 0.0;
    let mut want = vec![2.0_f32; 81];
    want[7 * 9 + 1] = 0.0;
    assert_close("plane", &median(9, 9, &depth), &want, EXACT);
    let step: Vec<f32> = (0..81).map(|i| if i % 9 < 4 { 1.0 } else { 3.0 }).collect();
    assert_close("a step keeps its place", &median(9, 9, &step), &step, EXACT);
}

#[test]
fn truth_of_ramps_and_lone_pixels() {
    if skipped() {
        return;
    }
    let ramp: Vec<f32> = (0..7 * 7).map(|i| 1.0 + (i % 7) as f32).collect();
    let row = [2.0_f32, 2.0, 3.0, 4.0, 5.0, 5.0, 6.0];
    let want: Vec<f32> = (0..49).map(|i| row[i % 7]).collect();
    assert_close("ramp", &median(7, 7, &ramp), &want, EXACT);
    let mut lone = vec![0.0_f32; 49];
    lone[24] = 4.0;
    assert_close("lone", &median(7, 7, &lone), &lone.clone(), EXACT);
}

#[test]
fn twin_at_every_share_of_holes() {
    if skipped() {
        return;
    }
    for (seed, holes) in [(1, 0.0), (2, 0.1), (3, 0.5), (4, 0.9)] {
        let depth = noisy(53, 31, holes, seed);
        let want = reference::spatial_median::spatial_median(53, 31, &depth);
        assert_close("noise", &median(53, 31, &depth), &want, EXACT);
    }
}

#[test]
fn edge_sizes() {
    if skipped() {
        return;
    }
    fragment(1, 1, &[1.0]).refuses_nothing(SPATIAL_MEDIAN);
    for (width, height) in [(1, 1), (15, 3), (16, 4), (17, 5), (1, 9), (33, 1)] {
        let depth = noisy(width, height, 0.2, 7);
        let want = reference::spatial_median::spatial_median(width, height, &depth);
        assert_close("small", &median(width, height, &depth), &want, EXACT);
    }
}

#[test]
fn poison_is_ordered_as_numbers() {
    if skipped() {
        return;
    }
    assert_close("zeros", &median(8, 8, &[0.0; 64]), &[0.0_f32; 64], EXACT);
    let mut depth = noisy(8, 8, 0.3, 9);
    // 2e-38 is a normal number: GPUs may take those below 1.2e-38 for 0.
    for (index, huge) in [(3, f32::MAX), (9, 1e38), (10, 2e30), (17, 2e-38), (63, f32::MAX)] {
        depth[index] = huge;
    }
    let want = reference::spatial_median::spatial_median(8, 8, &depth);
    assert_close("huge", &median(8, 8, &depth), &want, EXACT);
    let mut lone = vec![0.0; 64];
    lone[20] = f32::MAX;
    assert_close("lone huge", &median(8, 8, &lone), &lone.clone(), EXACT);
    // The ingest lets no NaN, infinity or negative depth through; were one here, it must not become depth.
    let poison = [f32::NAN, f32::NEG_INFINITY, -1.0, 0.0];
    let out = median(4, 1, &poison);
    assert_close("never measured", &out, &[0.0_f32; 4], EXACT);
}
