//! Twin of the passes of `limpid targets` (spec 1 §2), in f64.

use glam::DVec3;
use limpid::base::Rigid;
use limpid::sensor::CameraModel;
use limpid::stage::targets::Rule;

/// A pixel of the target camera: the nearest depth that falls on it (0: none), and whether f32 may see it otherwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Seen {
    pub(crate) depth_m: f64,
    pub(crate) doubtful: bool,
}

/// Distance in pixels of a border between pixels within which f32 may decide otherwise.
const EDGE_PX: f64 = 2e-3;

/// Depth of one frame as another camera of the same kind would have seen it.
pub(crate) fn reproject(camera: &CameraModel, depth_m: &[f32], target_from_view: Rigid) -> Vec<Seen> {
    let (width, height) = (i64::from(camera.width), i64::from(camera.height));
    let mut seen = vec![Seen { depth_m: 0.0, doubtful: false }; depth_m.len()];
    for (index, &depth) in depth_m.iter().enumerate() {
        let (u, v) = (index as i64 % width, index as i64 / width);
        let Some([x, y]) = camera.ray(u as f64, v as f64) else { continue };
        let point = target_from_view.transform_point(DVec3::new(x, y, 1.0) * f64::from(depth));
        if depth <= 0.0 || !(0.05..=1000.0).contains(&point.z) {
            continue;
        }
        let [x, y] = camera.distortion.distort([point.x / point.z, point.y / point.z]);
        let at = [x * camera.fx + camera.cx, y * camera.fy + camera.cy];
        let inside = |x: i64, y: i64| (0..width).contains(&x) && (0..height).contains(&y);
        let pixel = at.map(|a| (a + 0.5).floor() as i64);
        let doubtful = at.iter().any(|a| ((a + 0.5) - (a + 0.5).round()).abs() < EDGE_PX);
        for (dx, dy) in [(0, 0), (-1, 0), (1, 0), (0, -1), (0, 1), (-1, -1), (1, 1), (-1, 1), (1, -1)] {
            let (x, y) = (pixel[0] + dx, pixel[1] + dy);
            if !inside(x, y) || !(doubtful || (dx, dy) == (0, 0)) {
                continue;
            }
            let target = &mut seen[(y * width + x) as usize];
            target.doubtful |= doubtful;
            if (dx, dy) == (0, 0) && (target.depth_m == 0.0 || point.z < target.depth_m) {
                target.depth_m = point.z;
            }
        }
    }
    seen
}

/// What most of the views (depths, 0: none) agree on; 0 where too few do.
pub(crate) fn agree(views: &[f64], rule: &Rule, camera: &CameraModel) -> f64 {
    let support = |depth: f64| {
        let near = views.iter().filter(|&&d| d > 0.0 && (d - depth).abs() <= rule.tolerance_m(camera, depth));
        near.fold((0_u32, 0.0), |(count, sum), d| (count + 1, sum + d))
    };
    let all = views.iter().filter(|&&d| d > 0.0).count() as f64;
    let mut best = (0, 0.0);
    for &depth in views.iter().filter(|&&d| d > 0.0) {
        let found = support(depth);
        if found.0 > best.0 {
            best = found;
        }
    }
    let (count, sum) = support(best.1 / f64::from(best.0.max(1)));
    let agreed = count >= rule.least_views && f64::from(count) >= rule.least_share * all;
    if agreed { sum / f64::from(count) } else { 0.0 }
}

/// Reference, soft target, binary target, depth, and the native pixel, of a pixel of the network.
pub(crate) fn judge(
    native: [usize; 2],
    size: [usize; 2],
    pixel: usize,
    depth_m: &[f32],
    reference_m: &[f32],
    [share, noise_per_m]: [f64; 2],
) -> ([f64; 4], usize) {
    let scale = [0, 1].map(|axis| native[axis] as f64 / size[axis] as f64);
    let low = [(pixel / size[1]) as f64 * scale[0], (pixel % size[1]) as f64 * scale[1]];
    let mut best = (false, f64::INFINITY, 0);
    for (index, &depth) in depth_m.iter().enumerate() {
        let at = [(index / native[1]) as f64, (index % native[1]) as f64];
        let covered = [0, 1].map(|a| (low[a] + scale[a]).min(at[a] + 1.0) - low[a].max(at[a]));
        if covered[0] <= 1e-9 || covered[1] <= 1e-9 {
            continue;
        }
        let off = [0, 1].map(|a| at[a] + 0.5 - low[a] - scale[a] / 2.0);
        let distance = off[0] * off[0] + off[1] * off[1];
        let valid = depth > 0.0;
        // Equal distances: the first in reading order, up to the rounding of f32.
        if (valid && !best.0) || (valid == best.0 && distance < best.1 - 1e-4) {
            best = (valid, distance, index);
        }
    }
    let (valid, _, index) = best;
    let (depth, reference) = (f64::from(depth_m[index].max(0.0)), f64::from(reference_m[index]));
    if reference <= 0.0 {
        return ([0.0, 0.0, 0.0, depth], index);
    }
    let error = (depth - reference).abs();
    let delta = (share * reference).max(2.0 * noise_per_m * reference * reference);
    let soft = if valid { (-error / (share * reference)).exp() } else { 0.0 };
    ([reference, soft, f64::from(u8::from(valid && error <= delta)), depth], index)
}
