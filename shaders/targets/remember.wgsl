// A frame's depth into its slot of the window of frames that reference depth is drawn from.
// spec 1 §2.
struct RememberParams {
    words: u32,         // vec4 words of a slot
    slot: u32,
    pad0: u32,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> remember_params: RememberParams;
@group(0) @binding(1) var<storage, read> depth_m: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> window_m: array<vec4<f32>>;

@compute @workgroup_size(64)
fn remember(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < remember_params.words {
        window_m[remember_params.slot * remember_params.words + id.x] = depth_m[id.x];
    }
}
