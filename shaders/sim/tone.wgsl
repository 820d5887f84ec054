// The colour camera: exposed, with noise, clipped at highlights, sRGB; one word a pixel (r lowest).
struct SimToneParams {
    pixels: u32,
    seed: u32,
    electrons: f32,     // at full scale
    pad0: u32,
}

@group(0) @binding(0) var<uniform> tone_params: SimToneParams;
@group(0) @binding(1) var<storage, read> color_light: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> gain: array<f32>;
@group(0) @binding(3) var<storage, read_write> color: array<u32>;

fn srgb(linear: f32) -> f32 {
    return select(1.055 * pow(max(linear, 1.0e-6), 1.0 / 2.4) - 0.055, 12.92 * linear, linear <= 0.0031308);
}

@compute @workgroup_size(64)
fn tone(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= tone_params.pixels {
        return;
    }
    let packed = color_light[id.x];
    let signal = vec3(unpack2x16float(packed.x), unpack2x16float(packed.y).x) * gain[0];
    let bits = hash(id.x ^ hash(tone_params.seed));
    let grain = vec3(normal(bits), normal(hash(bits)), normal(hash(bits + 1u)));
    let linear = clamp(signal + grain * sqrt(min(signal, vec3(1.0)) / tone_params.electrons), vec3(0.0), vec3(1.0));
    let levels = vec3<u32>(vec3(srgb(linear.x), srgb(linear.y), srgb(linear.z)) * 255.0 + 0.5);
    color[id.x] = levels.x | (levels.y << 8u) | (levels.z << 16u) | 0xff000000u;
}
