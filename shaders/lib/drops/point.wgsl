// The points of a scan that are looked at: one of every `stride`, drawn by a hash, as rings take turns in the order of points.
// Needs lib/hash, lib/numbers, lib/points, lib/drops/drops.

// The place of one in the lidar's frame, w: 1; w = 0: there is none.
fn point_of(number: u32) -> vec4<f32> {
    let stride = max(drop_params.stride, 1u);
    let index = number * stride + hash(number) % stride;
    if number >= drop_params.columns || index >= drop_params.measured {
        return vec4(0.0);
    }
    let at = bitcast<vec3<f32>>(point_words(2u * index).xyz);
    if !(is_finite(at.x) && is_finite(at.y) && is_finite(at.z)) {
        return vec4(0.0);
    }
    return vec4(at, 1.0);
}
