//! The passes around the network: its input from depth and colour, and its output at the native size.

use limpid::Config;
use limpid::gpu::Invocations;
use limpid::network::Backend;
use limpid::stage::camera::drm::{ResizeParams, RestoreParams, resize, restore};

use crate::reference;
use crate::support::compare::{Tolerance, assert_close};
use crate::support::gpu::{Fragment, skipped};
use crate::support::random::Random;

const ROUNDING: Tolerance = Tolerance { absolute: 2e-5, reason: "pixel positions and shares are float32" };

/// Tensors as buffers, whose content can be read.
const BUFFERS: Backend = Backend { textures: false, subgroups: false };

/// What the pass makes of a frame: planes of R, G, B, depth and change, and the depth that it keeps.
fn resized(
    native: [u32; 2],
    size: [u32; 2],
    depth_m: &[f32],
    color: &[u32],
    before_m: &[f32],
) -> (Vec<f32>, Vec<f32>) {
    let (text, invocations) = resize(native, size, BUFFERS);
    let pixels = (size[0] * size[1]) as usize;
    let out = Fragment::new()
        .params("resize_params", &ResizeParams::new(10.0, Some(0.03)))
        .input("depth_m", depth_m)
        .input("color", color)
        .changed("depth_before", before_m)
        .output("sink", pixels * 8)
        .run(text, invocations);
    let quads = out.floats("sink");
    let plane = |c: usize| (0..pixels).map(move |i| (c / 4 * pixels + i) * 4 + c % 4);
    // Channels that are no input are 0.
    assert!((5..8).flat_map(plane).all(|at| quads[at] == 0.0));
    ((0..5).flat_map(plane).map(|at| quads[at]).collect(), out.floats("depth_before"))
}

fn restored(native: [u32; 2], size: [u32; 2], low: &[f32], depth_m: &[f32]) -> Vec<f32> {
    restored_as(false, native, size, low, depth_m)
}

/// `alone`: of a frame without usable colour.
fn restored_as(alone: bool, native: [u32; 2], size: [u32; 2], low: &[f32], depth_m: &[f32]) -> Vec<f32> {
    let (text, invocations) = restore(native, size, BUFFERS);
    let params = RestoreParams::new(&Config::default(), alone);
    let fragment = Fragment::new().params("restore_params", &params);
    let fragment = fragment.input("reliability_low", low).input("depth_m", depth_m);
    fragment.output("reliability", depth_m.len()).run(text, invocations).floats("reliability")
}

fn grey(values: impl Iterator<Item = u8>) -> Vec<u32> {
    values.map(|v| u32::from_le_bytes([v, v, v, 255])).collect()
}

#[test]
fn truth_halves_colour_by_mean_and_depth_by_the_nearest_that_there_is() {
    if skipped() {
        return;
    }
    // 2 x 4 pixels to 1 x 2: each a mean of four, each the first depth of four equally near.
    let color = grey([10, 20, 200, 255, 30, 40, 100, 45].into_iter());
    let depth = [0.0, 0.0, 5.0, 6.0, 0.0, 2.0, 7.0, 8.0];
    let (planes, kept) = resized([2, 4], [1, 2], &depth, &color, &[2.5, 0.0]);
    let mean = [25.0 / 255.0, 150.0 / 255.0];
    let want = [mean, mean, mean, [0.2, 0.5], [0.05, 0.0]].concat();
    assert_close("planes", &planes, &want, ROUNDING);
    assert_eq!(kept, [2.0, 5.0]);
}

#[test]
fn truth_a_hole_stays_a_hole_and_colour_that_is_not_there_does_not_count() {
    if skipped() {
        return;
    }
    let mut color = grey([100; 36].into_iter());
    color[0] = 0;
    color[1] = 0;
    let mut depth = [3.0; 36];
    for index in [0, 1, 2, 6, 7, 8, 12, 13, 14] {
        depth[index] = 0.0;
    }
    let (planes, kept) = resized([6, 6], [2, 2], &depth, &color, &[1.0, 3.0, 3.5, 0.0]);
    let level = 100.0 / 255.0;
    let want = [vec![level; 12], vec![0.0, 0.3, 0.3, 0.3], vec![0.0, 0.0, 0.05, 0.0]].concat();
    assert_close("planes", &planes, &want, ROUNDING);
    assert_eq!(kept, [0.0, 3.0, 3.0, 3.0]);
}

#[test]
fn truth_a_ramp_stays_a_ramp_at_the_native_size() {
    if skipped() {
        return;
    }
    // 8x4 values that rise by 0.1 a column, at thrice the size: 1/30 a column away from the border.
    let low: Vec<f32> = (0..32).map(|i| (i % 8) as f32 * 0.1).collect();
    let got = restored([12, 24], [4, 8], &low, &[1.0; 12 * 24]);
    let want: Vec<f32> =
        (0..288).map(|i| (((i % 24) as f32 + 0.5) / 3.0 - 0.5).clamp(0.0, 7.0) * 0.1).collect();
    assert_close("ramp", &got, &want, ROUNDING);
}

#[test]
fn truth_without_colour_depth_counts_within_the_range_of_method_range() {
    if skipped() {
        return;
    }
    // From depth_min_m = 0.17 to range_gate_m = 5, limits included; what the network left does not matter.
    let depth = [0.0, 0.1, 0.169, 0.17, 1.0, 4.999, 5.0, 5.01, 9.0, f32::MAX, 2.0, 3.0];
    let low = [0.25, f32::NAN, f32::INFINITY, -1.0].repeat(4);
    let got = restored_as(true, [3, 4], [4, 4], &low, &depth);
    assert_eq!(got, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0]);
    let weighed = restored([3, 4], [4, 4], &[0.25; 16], &depth);
    assert_eq!(weighed[3..], [0.25; 9], "the control: with colour the network weighs");
}

/// Native sizes against sizes of the network: whole and broken ratios, both ways, rows that fill no word of four.
const SIZES: [([u32; 2], [u32; 2]); 8] = [
    ([48, 64], [24, 32]),
    ([48, 84], [24, 32]),
    ([45, 53], [16, 16]),
    ([12, 16], [24, 32]),
    ([30, 31], [24, 32]),
    ([1, 1], [4, 4]),
    ([3, 130], [4, 4]),
    ([64, 65], [64, 64]),
];

#[test]
fn twins_at_edge_sizes() {
    if skipped() {
        return;
    }
    let mut random = Random(5);
    for (native, size) in SIZES {
        let count = (native[0] * native[1]) as usize;
        let depth: Vec<f32> =
            (0..count).map(|_| if random.chance(0.3) { 0.0 } else { 0.2 + 9.0 * random.unit() }).collect();
        let color: Vec<u32> = (0..count)
            .map(|_| random.below(1 << 24) | if random.chance(0.8) { 0xff00_0000 } else { 0 })
            .collect();
        let color: Vec<u32> = color.into_iter().map(|c| if c >> 24 == 0 { 0 } else { c }).collect();
        let pixels = (size[0] * size[1]) as usize;
        let before: Vec<f32> =
            (0..pixels).map(|_| if random.chance(0.3) { 0.0 } else { 5.0 * random.unit() }).collect();
        let as_usize = |s: [u32; 2]| s.map(|v| v as usize);
        let (planes, kept) = resized(native, size, &depth, &color, &before);
        let (want, want_kept) =
            reference::drm::resize(as_usize(native), as_usize(size), &depth, &color, &before, 10.0);
        assert_close(&format!("{native:?} to {size:?}"), &planes, &want, ROUNDING);
        assert_eq!(kept, want_kept);
        let low: Vec<f32> = (0..pixels).map(|_| random.unit()).collect();
        let want = reference::drm::restore(as_usize(native), as_usize(size), &low, &depth);
        assert_close(
            &format!("{size:?} to {native:?}"),
            &restored(native, size, &low, &depth),
            &want,
            ROUNDING,
        );
    }
}

#[test]
fn poison_stays_a_share() {
    if skipped() {
        return;
    }
    let low = [f32::NAN, f32::INFINITY, -3.0, 7.0].repeat(4);
    let got = restored([8, 8], [4, 4], &low[..16], &[1.0; 64]);
    assert!(got.iter().all(|r| r.is_nan() || (0.0..=1.0).contains(r)), "{got:?}");
    let got = restored([8, 8], [4, 4], &[-3.0, 7.0].repeat(8), &[1.0; 64]);
    assert!(got.iter().all(|r| (0.0..=1.0).contains(r)), "{got:?}");
    let none = restored([8, 8], [4, 4], &[1.0; 16], &[0.0; 64]);
    assert!(none.iter().all(|&r| r == 0.0));
}

#[test]
fn nothing_to_do_is_refused() {
    let (text, _) = restore([8, 8], [4, 4], BUFFERS);
    let mut plan = limpid::gpu::Plan::default();
    plan.uniform::<RestoreParams>("restore_params").unwrap();
    for name in ["reliability_low", "depth_m"] {
        plan.upload(name, 256).unwrap();
    }
    plan.scratch("reliability", 256).unwrap();
    let reason = plan.step(text, Invocations([0, 1, 1]), &[]).unwrap_err().to_string();
    assert!(reason.contains("net/restore") && reason.contains("an extent is 0"), "{reason}");
}
