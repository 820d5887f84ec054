// Counts the candidates near each hypothesis: a plane through three of them, drawn by a hash. spec 3 §3 (RANSAC). And empties
// the survey of the plane that comes of them: many invocations are faster at that than those of the fit.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var candidates: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(2) var<storage, read> found: Found;
@group(0) @binding(3) var<storage, read_write> scores: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> survey: array<u32>;

// Each hypothesis is counted by this many invocations, each of which counts this many hypotheses.
const PARTS = 16u;
const TOGETHER = 8u;

fn near_planes(planes: mat4x4<f32>, p: vec3<f32>) -> vec4<u32> {
    let off = abs(vec4(p, -1.0) * planes);
    return select(vec4(0u), vec4(1u), off < vec4(glass_params.fit_tolerance_m));
}

fn four_from(first: u32, count: u32) -> mat4x4<f32> {
    return mat4x4<f32>(
        hypothesis(first, count),
        hypothesis(first + 1u, count),
        hypothesis(first + 2u, count),
        hypothesis(first + 3u, count),
    );
}

fn add(planes: mat4x4<f32>, near: vec4<u32>, first: u32, hypotheses: u32) {
    for (var k = 0u; k < 4u; k++) {
        if near[k] > 0u && planes[k].w > 0.0 && first + k < hypotheses {
            atomicAdd(&scores[first + k], near[k]);
        }
    }
}

@compute @workgroup_size(16, 4)
fn score(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let count = found.candidates;
    let first = id.x * TOGETHER;
    let hypotheses = min(glass_params.hypotheses, MOST_HYPOTHESES);
    let enough = count >= max(glass_params.min_inliers, 3u);
    let begin = id.y * 16u * groups.x + id.x;
    let stride = 64u * groups.x * groups.y;
    let words = turns_from(begin, select(0u, SURVEY_COUNTS * SURVEY_SQUARES, enough), stride);
    for (var k = 0u; k < words; k++) {
        survey[begin + k * stride] = 0u;
    }
    for (var turn = 0u; turn < turns_if(first < hypotheses && id.y < PARTS && enough); turn++) {
        let here = four_from(first, count);
        let next = four_from(first + 4u, count);
        var near_here = vec4(0u);
        var near_next = vec4(0u);
        for (var k = id.y; k < min(count, MOST_CANDIDATES); k += PARTS) {
            let p = candidate_at(k).xyz;
            near_here += near_planes(here, p);
            near_next += near_planes(next, p);
        }
        add(here, near_here, first, hypotheses);
        add(next, near_next, first + 4u, hypotheses);
    }
}
