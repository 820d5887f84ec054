// Packs the cells that cameras call occupied into bits, row by row.
// spec 1 §9, step 7. Needs lib/verdict, the rows of the rule that bridge.
struct BridgeOccupiedParams {
    side: u32,
    words: u32,     // 32-bit words a row
}

@group(0) @binding(0) var<uniform> bridge_occupied_params: BridgeOccupiedParams;
@group(0) @binding(1) var<storage, read> verdicts: array<u32>;
@group(0) @binding(2) var<storage, read_write> camera_bits: array<u32>;

@compute @workgroup_size(64)
fn occupied(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = bridge_occupied_params.side;
    let words = bridge_occupied_params.words;
    if id.x >= side * words {
        return;
    }
    let row = id.x / words;
    let first = (id.x % words) * 32u;
    var bits = 0u;
    for (var i = 0u; i < min(32u, side - first); i++) {
        let by_camera = ((OCCUPIED_ROWS >> verdict_row(verdicts[row * side + first + i])) & 1u) != 0u;
        bits |= select(0u, 1u << i, by_camera);
    }
    camera_bits[id.x] = bits;
}
