// Marks the beams that may end on glass: two returns that differ, of which the nearer is not in the last slot, or an
// intensity peak. One bit for each cell, columns in turn. spec 3 §2, §3.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var<storage, read> beam_cells: array<u32>;
@group(0) @binding(2) var<storage, read> peaks: array<u32>;
@group(0) @binding(3) var<storage, read_write> candidate_bits: array<u32>;
@group(0) @binding(4) var<storage, read_write> glass_counters: array<atomic<u32>>;

@compute @workgroup_size(64)
fn candidate(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = glass_params.rows * glass_params.columns;
    if 32u * id.x >= size {
        return;
    }
    var bits = 0u;
    var dual = 0u;
    var peak = 0u;
    for (var k = 0u; k < 32u; k++) {
        let place = 32u * id.x + k;
        if place < size {
            let first = beam_cells[2u * place];
            let last = beam_cells[2u * place + 1u];
            let differ = two_returns(first, last);
            let shines = first != NONE && peaks[place] != 0u;
            bits |= select(0u, 1u << k, differ || shines);
            dual += select(0u, 1u, differ);
            peak += select(0u, 1u, shines);
        }
    }
    candidate_bits[id.x] = bits;
    if dual > 0u {
        atomicAdd(&glass_counters[COUNT_DUAL], dual);
    }
    if peak > 0u {
        atomicAdd(&glass_counters[COUNT_PEAK], peak);
    }
}
