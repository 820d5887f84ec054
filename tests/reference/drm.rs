//! Twin of the passes around the network: resize and restore (spec 1 §1), in f64.

/// Share of each source pixel that `[low, low + scale)` covers, as (pixel, share).
fn covered(low: f64, scale: f64, count: usize) -> Vec<(usize, f64)> {
    let overlap = |i: usize| (low + scale).min(i as f64 + 1.0) - low.max(i as f64);
    (0..count).map(|i| (i, overlap(i))).filter(|(_, share)| *share > 1e-9).collect()
}

/// Planes of R, G, B, depth and change at `size` rows and columns; the resized depth in metres too. `color` is packed RGBA
/// with alpha 0 where there is none.
pub(crate) fn resize(
    native: [usize; 2],
    size: [usize; 2],
    depth_m: &[f32],
    color: &[u32],
    before_m: &[f32],
    depth_scale_m: f64,
) -> (Vec<f32>, Vec<f32>) {
    let scale = [native[0] as f64 / size[0] as f64, native[1] as f64 / size[1] as f64];
    let pixels = size[0] * size[1];
    let mut planes = vec![0.0_f32; 5 * pixels];
    let mut resized = vec![0.0_f32; pixels];
    for pixel in 0..pixels {
        let low = [(pixel / size[1]) as f64 * scale[0], (pixel % size[1]) as f64 * scale[1]];
        let (mut sums, mut total, mut nearest) = ([0.0; 3], 0.0, (f64::INFINITY, 0.0_f32));
        for (y, height) in covered(low[0], scale[0], native[0]) {
            for (x, width) in covered(low[1], scale[1], native[1]) {
                let index = y * native[1] + x;
                let bytes = color[index].to_le_bytes();
                let weight = height * width * f64::from(bytes[3]) / 255.0;
                (0..3).for_each(|c| sums[c] += weight * f64::from(bytes[c]) / 255.0);
                total += weight;
                let off =
                    [y as f64 + 0.5 - low[0] - scale[0] / 2.0, x as f64 + 0.5 - low[1] - scale[1] / 2.0];
                let distance = off[0] * off[0] + off[1] * off[1];
                // Equal distances: the first in reading order, up to the rounding of f32.
                if depth_m[index] > 0.0 && distance < nearest.0 - 1e-4 {
                    nearest = (distance, depth_m[index]);
                }
            }
        }
        let (depth, before) = (nearest.1, before_m[pixel]);
        let change = if depth > 0.0 && before > 0.0 { f64::from(depth) - f64::from(before) } else { 0.0 };
        let color = sums.map(|sum| if total > 0.0 { sum / total } else { 0.0 });
        let values =
            [color[0], color[1], color[2], f64::from(depth) / depth_scale_m, change.abs() / depth_scale_m];
        (0..5).for_each(|c| planes[c * pixels + pixel] = values[c] as f32);
        resized[pixel] = depth;
    }
    (planes, resized)
}

/// Reliability of `size` rows and columns at `native` ones, bilinearly; 0 without depth.
pub(crate) fn restore(native: [usize; 2], size: [usize; 2], low: &[f32], depth_m: &[f32]) -> Vec<f32> {
    let split = |i: usize, axis: usize| {
        let place = (i as f64 + 0.5) * size[axis] as f64 / native[axis] as f64 - 0.5;
        let place = place.clamp(0.0, size[axis] as f64 - 1.0);
        (place.floor() as usize, (place.floor() as usize + 1).min(size[axis] - 1), place - place.floor())
    };
    let value = |index: usize| {
        let ((y0, y1, v), (x0, x1, u)) = (split(index / native[1], 0), split(index % native[1], 1));
        let at = |y: usize, x: usize| f64::from(low[y * size[1] + x]);
        let row = |y: usize| at(y, x0) * (1.0 - u) + at(y, x1) * u;
        (row(y0) * (1.0 - v) + row(y1) * v) as f32
    };
    (0..native[0] * native[1]).map(|i| if depth_m[i] > 0.0 { value(i) } else { 0.0 }).collect()
}
