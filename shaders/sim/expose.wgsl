// An infrared image as the imager gives it: exposed, with shot and read noise, saturated, 8 bits; four pixels a word.
// spec 1 §8.
struct SimExposeParams {
    words: u32,             // of four pixels
    seed: u32,              // differs by frame and camera
    electrons: f32,         // at full scale
    read_noise: f32,        // share of full scale
    full_gain: f32,         // gain up to which exposure alone serves; above it fewer electrons make full scale
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> expose_params: SimExposeParams;
@group(0) @binding(1) var<storage, read> infrared: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> gain: array<f32>;
@group(0) @binding(3) var<storage, read_write> grey: array<u32>;

fn noise(at: u32) -> f32 {
    return normal(hash(at ^ hash(expose_params.seed)));
}

@compute @workgroup_size(64)
fn expose(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= expose_params.words {
        return;
    }
    let exposure = gain[0];
    let electrons = expose_params.electrons * min(1.0, expose_params.full_gain / max(exposure, 1.0e-9));
    let signal = infrared[id.x] * exposure;
    let deviation = sqrt(min(signal, vec4(1.0)) / electrons + expose_params.read_noise * expose_params.read_noise);
    let first = id.x * 4u;
    let grain = vec4(noise(first), noise(first + 1u), noise(first + 2u), noise(first + 3u));
    let levels = vec4<u32>(clamp((signal + deviation * grain) * 255.0 + 0.5, vec4(0.0), vec4(255.0)));
    grey[id.x] = levels.x | (levels.y << 8u) | (levels.z << 16u) | (levels.w << 24u);
}
