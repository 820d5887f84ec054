// Counts the candidates near each hypothesis: a plane through three of them, drawn by a hash. spec 3 §3 (RANSAC).
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var<storage, read> candidates: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> found: Found;
@group(0) @binding(3) var<storage, read_write> scores: array<atomic<u32>>;

// Each hypothesis is counted by this many invocations, each of which counts this many hypotheses.
const PARTS = 16u;
const TOGETHER = 4u;

@compute @workgroup_size(16, 4)
fn score(@builtin(global_invocation_id) id: vec3<u32>) {
    let count = found.candidates;
    let first = id.x * TOGETHER;
    let hypotheses = min(glass_params.hypotheses, MOST_HYPOTHESES);
    if first >= hypotheses || id.y >= PARTS || count < glass_params.min_inliers || count < 3u {
        return;
    }
    let planes = mat4x4<f32>(
        hypothesis(first, count),
        hypothesis(first + 1u, count),
        hypothesis(first + 2u, count),
        hypothesis(first + 3u, count),
    );
    var near = vec4(0u);
    for (var k = id.y; k < count; k += PARTS) {
        let off = abs(vec4(candidates[k].xyz, -1.0) * planes);
        near += select(vec4(0u), vec4(1u), off < vec4(glass_params.fit_tolerance_m));
    }
    for (var k = 0u; k < TOGETHER; k++) {
        if near[k] > 0u && planes[k].w > 0.0 && first + k < hypotheses {
            atomicAdd(&scores[first + k], near[k]);
        }
    }
}
