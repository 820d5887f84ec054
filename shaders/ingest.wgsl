// Raw depth samples to metres, 0 where there is no depth in the method's range; reliability 1 where there is.
// spec 1 §1 (invalid depth is 0), §4 (range gating, w = 1).
struct IngestParams {
    words: u32,         // vec4 words of raw data
    unit_m: f32,        // metres per count
    raw_min: u32,       // smallest and largest count taken as measured
    raw_max: u32,
    depth_min_m: f32,   // the same for floats
    depth_max_m: f32,
    pad0: u32,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> ingest_params: IngestParams;
@group(0) @binding(1) var<storage, read> depth_raw: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> depth_m: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> reliability: array<vec4<f32>>;

// Whether samples are float metres, else 16-bit counts, two a word.
override floats: bool = false;

fn from_counts(words: vec2<u32>) -> vec4<f32> {
    let raw = vec4(words.x & 0xffffu, words.x >> 16u, words.y & 0xffffu, words.y >> 16u);
    let measured = raw >= vec4(ingest_params.raw_min) & raw <= vec4(ingest_params.raw_max);
    return select(vec4(0.0), vec4<f32>(raw) * ingest_params.unit_m, measured);
}

fn from_float(word: u32) -> f32 {
    let depth = bitcast<f32>(word);
    let measured = is_finite(depth) && depth > 0.0
        && depth >= ingest_params.depth_min_m && depth <= ingest_params.depth_max_m;
    return select(0.0, depth, measured);
}

fn store(i: u32, depth: vec4<f32>) {
    depth_m[i] = depth;
    reliability[i] = select(vec4(0.0), vec4(1.0), depth > vec4(0.0));
}

@compute @workgroup_size(64)
fn ingest(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    if i >= ingest_params.words {
        return;
    }
    let raw = depth_raw[i];
    if floats {
        store(i, vec4(from_float(raw.x), from_float(raw.y), from_float(raw.z), from_float(raw.w)));
    } else {
        store(2u * i, from_counts(raw.xy));
        store(2u * i + 1u, from_counts(raw.zw));
    }
}
