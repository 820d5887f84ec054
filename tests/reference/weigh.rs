//! w(u) = R(u) (spec 1 §3): the sensor's confidence; 0 without depth.

/// Weight per pixel.
pub(crate) fn weigh(depth_m: &[f32], confidence: &[f32]) -> Vec<f32> {
    let trust = |value: f32| if value.is_finite() { value.clamp(0.0, 1.0) } else { 0.0 };
    depth_m.iter().zip(confidence).map(|(&d, &c)| if d > 0.0 { trust(c) } else { 0.0 }).collect()
}
