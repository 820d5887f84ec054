// Sums what the passes counted on their way: a few invocations, so that few atomics meet in one word.
// spec 1 §5 (the fraction of low-reliability pixels).
struct TallyParams {
    strips: u32,
    cells: u32,
    invocations: u32,
    pad: u32,
}

@group(0) @binding(0) var<uniform> tally_params: TallyParams;
@group(0) @binding(1) var<storage, read> strip_counts: array<u32>;
@group(0) @binding(2) var<storage, read> state: array<u32>;
@group(0) @binding(3) var<storage, read_write> counters: array<atomic<u32>>;

fn add(counter: u32, count: u32) {
    if count > 0u {
        atomicAdd(&counters[counter], count);
    }
}

@compute @workgroup_size(64)
fn tally(@builtin(global_invocation_id) id: vec3<u32>) {
    var pixels = vec3(0u);
    for (var i = id.x; i < tally_params.strips; i += tally_params.invocations) {
        pixels += (vec3(strip_counts[i]) >> vec3(0u, 8u, 16u)) & vec3(0xffu);
    }
    var cells = vec4(0u);
    for (var i = id.x; i < tally_params.cells; i += tally_params.invocations) {
        let word = state[i];
        let counted = vec4(
            (word & WAS_HIT) != 0u,
            (word & WAS_SEEN_THROUGH) != 0u,
            see_state(word) == OCCUPIED,
            see_state(word) == FREE,
        );
        cells += select(vec4(0u), vec4(1u), counted);
    }
    add(VALID_PIXELS, pixels.x);
    add(LOW_RELIABILITY_PIXELS, pixels.y);
    add(HIT_PIXELS, pixels.z);
    add(HIT_CELLS, cells.x);
    add(SEEN_THROUGH_CELLS, cells.y);
    add(OCCUPIED_CELLS, cells.z);
    add(FREE_CELLS, cells.w);
}
