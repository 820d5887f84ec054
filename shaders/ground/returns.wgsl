// Samples of a scan for the ground: one point of every so many, drawn by a hash, as rings take turns in the order of points;
// those that lie below the lidar. spec 6 §2.
@group(0) @binding(0) var<uniform> ground_params: GroundParams;
@group(0) @binding(2) var ground_samples: texture_storage_2d_array<rgba32float, write>;

@compute @workgroup_size(64)
fn returns(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= MOST_SAMPLES {
        return;
    }
    var taken = vec4(0.0);
    let stride = max(ground_params.stride, 1u);
    let index = id.x * stride + hash(id.x) % stride;
    if id.x < ground_params.columns && index < ground_params.measured {
        let words = point_words(2u * index);
        let place = bitcast<vec3<f32>>(words.xyz);
        if is_finite(place.x) && is_finite(place.y) && is_finite(place.z) {
            taken = sample_of(turned(place));
        }
    }
    textureStore(ground_samples, sample_texel(id.x), 0u, taken);
}
