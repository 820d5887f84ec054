// Weights pixels by the sensor's own confidence in [0, 1]; pixels without depth keep 0.
// spec 1 §3 (w(u) = R(u)).
struct WeighParams {
    words: u32,     // vec4 words of pixels
}

@group(0) @binding(0) var<uniform> weigh_params: WeighParams;
@group(0) @binding(1) var<storage, read> confidence_raw: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> reliability: array<vec4<f32>>;

fn usable(value: f32) -> f32 {
    return select(0.0, clamp(value, 0.0, 1.0), is_finite(value));
}

@compute @workgroup_size(64)
fn weigh(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= weigh_params.words {
        return;
    }
    let raw = confidence_raw[id.x];
    reliability[id.x] *= vec4(usable(raw.x), usable(raw.y), usable(raw.z), usable(raw.w));
}
