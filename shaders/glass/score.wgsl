// Counts the candidates near each hypothesis: a plane through three of them, drawn by a hash. spec 3 §3 (RANSAC).
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var<storage, read> candidates: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> found: Found;
@group(0) @binding(3) var<storage, read_write> scores: array<atomic<u32>>;

// Each hypothesis is counted by this many invocations.
const PARTS = 8u;

@compute @workgroup_size(64)
fn score(@builtin(global_invocation_id) id: vec3<u32>) {
    let count = found.candidates;
    if id.x >= min(glass_params.hypotheses, MOST_HYPOTHESES) || id.y >= PARTS || count < 3u {
        return;
    }
    let plane = hypothesis(id.x, count);
    if plane.w <= 0.0 {
        return;
    }
    var near = 0u;
    for (var k = id.y; k < count; k += PARTS) {
        let off = abs(dot(plane.xyz, candidates[k].xyz) - plane.w);
        near += select(0u, 1u, off < glass_params.fit_tolerance_m);
    }
    if near > 0u {
        atomicAdd(&scores[id.x], near);
    }
}
