// Colour that lies on the depth grid already: three bytes a pixel to one word, four pixels at a time; black where there is none.
// spec 1 §1 (colour is sampled at the depth camera's pixels).
struct AlignColorParams {
    words: u32,         // of four pixels
    present: u32,       // 0: this frame has no colour
    pad0: u32,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> align_color_params: AlignColorParams;
@group(0) @binding(1) var<storage, read> color_raw: array<u32>;
@group(0) @binding(2) var<storage, read_write> color: array<vec4<u32>>;

@compute @workgroup_size(64)
fn align_color(@builtin(global_invocation_id) id: vec3<u32>) {
    let word = id.x;
    if word >= align_color_params.words {
        return;
    }
    let a = color_raw[3u * word];
    let b = color_raw[3u * word + 1u];
    let c = color_raw[3u * word + 2u];
    let pixels = vec4(a, (a >> 24u) | (b << 8u), (b >> 16u) | (c << 16u), c >> 8u);
    let shown = (pixels & vec4(0xffffffu)) | vec4(0xff000000u);
    color[word] = select(vec4(0u), shown, align_color_params.present == 1u);
}
