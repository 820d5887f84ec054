// Packs the cells whose verdict is lethal into bits, row by row.
// spec 1 §3 (inflation), spec 4 §2 (inflation follows the verdict).
struct InflatePackParams {
    side: u32,
    words: u32,     // 32-bit words a row
}

@group(0) @binding(0) var<uniform> inflate_pack_params: InflatePackParams;
@group(0) @binding(1) var<storage, read> verdicts: array<u32>;
@group(0) @binding(2) var<storage, read_write> occupied_bits: array<u32>;

@compute @workgroup_size(64)
fn pack(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = inflate_pack_params.side;
    let words = inflate_pack_params.words;
    if id.x >= side * words {
        return;
    }
    let row = id.x / words;
    let first = (id.x % words) * 32u;
    var bits = 0u;
    for (var i = 0u; i < min(32u, side - first); i++) {
        let is_obstacle = verdict_cost(verdicts[row * side + first + i]) == COST_LETHAL;
        bits |= select(0u, 1u << i, is_obstacle);
    }
    occupied_bits[id.x] = bits;
}
