// 1 / (1 + exp(-x)); 0 where a network of huge weights overflowed. Needs lib/numbers.
fn reliability_of(logit: f32) -> f32 {
    let sigmoid = 1.0 / (1.0 + exp(-clamp(logit, -80.0, 80.0)));
    return select(0.0, sigmoid, is_finite(logit));
}
