//! Median of the valid depths in 5x5 around each valid pixel, the lower of two middles (spec 1 §4).

/// Depth in metres, 0 where there is none.
pub(crate) fn spatial_median(width: usize, height: usize, depth_m: &[f32]) -> Vec<f32> {
    let at = |x: usize, y: usize| depth_m[y * width + x];
    let mut out = Vec::with_capacity(width * height);
    for y in 0..height {
        for x in 0..width {
            if at(x, y) <= 0.0 {
                out.push(0.0);
                continue;
            }
            let mut valid = Vec::new();
            for ny in y.saturating_sub(2)..=(y + 2).min(height - 1) {
                for nx in x.saturating_sub(2)..=(x + 2).min(width - 1) {
                    valid.extend(Some(at(nx, ny)).filter(|&d| d > 0.0));
                }
            }
            valid.sort_by(f32::total_cmp);
            out.push(valid[(valid.len() - 1) / 2]);
        }
    }
    out
}
