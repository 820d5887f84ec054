// Counts the samples on each plane that was drawn. spec 6 §2 (RANSAC).
@group(0) @binding(0) var<uniform> ground_params: GroundParams;
@group(0) @binding(1) var ground_samples: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(2) var<storage, read> ground_planes: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> ground_scores: array<atomic<u32>>;

// Each plane is counted by this many invocations, each of which counts this many planes.
const PARTS = 16u;
const TOGETHER = 8u;

fn four_from(first: u32) -> mat4x4<f32> {
    return mat4x4<f32>(
        ground_planes[first],
        ground_planes[first + 1u],
        ground_planes[first + 2u],
        ground_planes[first + 3u],
    );
}

fn on_planes(planes: mat4x4<f32>, taken: vec4<f32>) -> vec4<u32> {
    let off = abs(vec4(taken.xyz, -1.0) * planes);
    return select(vec4(0u), vec4(1u), off < vec4(taken.w));
}

fn add(first: u32, counts: vec4<u32>) {
    for (var k = 0u; k < 4u; k++) {
        if counts[k] > 0u {
            atomicAdd(&ground_scores[first + k], counts[k]);
        }
    }
}

@compute @workgroup_size(16, 4)
fn score(@builtin(global_invocation_id) id: vec3<u32>) {
    let first = id.x * TOGETHER;
    if first >= HYPOTHESES || id.y >= PARTS {
        return;
    }
    let here = four_from(first);
    let next = four_from(first + 4u);
    let samples = min(ground_params.columns * ground_params.rows, MOST_SAMPLES);
    var on_here = vec4(0u);
    var on_next = vec4(0u);
    for (var k = id.y; k < min(samples, MOST_SAMPLES); k += PARTS) {
        let taken = textureLoad(ground_samples, sample_texel(k), 0u);
        on_here += on_planes(here, taken);
        on_next += on_planes(next, taken);
    }
    add(first, on_here);
    add(first + 4u, on_next);
}
