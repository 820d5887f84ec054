//! w(u) = R(u) (spec 1 §3): 1 for the classical methods, or the sensor's confidence; 0 without depth.

/// Weight per pixel.
pub(crate) fn weigh(depth_m: &[f32], confidence: Option<&[f32]>) -> Vec<f32> {
    let trust = |index: usize| match confidence {
        None => 1.0,
        Some(values) if values[index].is_finite() => values[index].clamp(0.0, 1.0),
        Some(_) => 0.0,
    };
    depth_m.iter().enumerate().map(|(index, &depth)| if depth > 0.0 { trust(index) } else { 0.0 }).collect()
}
