// Reliability of the classical methods: 1 where there is depth, 0 where there is none.
// spec 1 §4 (w = 1).
struct WeighParams {
    words: u32,     // vec4 words of pixels
}

@group(0) @binding(0) var<uniform> weigh_params: WeighParams;
@group(0) @binding(1) var<storage, read> depth_m: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> reliability: array<vec4<f32>>;

@compute @workgroup_size(64)
fn constant(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= weigh_params.words {
        return;
    }
    reliability[id.x] = select(vec4(0.0), vec4(1.0), depth_m[id.x] > vec4(0.0));
}
