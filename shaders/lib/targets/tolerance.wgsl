// delta of spec 1 §2: how far measurements of one surface at `depth` metres may lie apart.
// `share` of the depth, or twice the stereo noise of `noise_per_m` d^2 metres, whichever is more.
fn tolerance_m(depth: f32, share: f32, noise_per_m: f32) -> f32 {
    return max(share * depth, 2.0 * noise_per_m * depth * depth);
}
