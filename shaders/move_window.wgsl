// Moves the window by whole cells: cells that stay keep their state, new ones start unknown; clears the frame's sums.
// spec 1 §3 (local map).
struct MoveWindowParams {
    side: u32,
    origin_slot_x: u32,     // slot of window cell (0, 0)
    origin_slot_y: u32,
    shift_x: i32,           // cells moved since the frame before
    shift_y: i32,
    forget: u32,            // 1: every cell starts unknown
}

@group(0) @binding(0) var<uniform> move_window_params: MoveWindowParams;
@group(0) @binding(1) var<storage, read_write> cells: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read_write> cell_hits: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> seen_through: array<u32>;
@group(0) @binding(4) var<storage, read_write> counters: array<u32>;

@compute @workgroup_size(16, 4)
fn move_window(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = move_window_params.side;
    let x = id.x;
    let y = id.y;
    if x < COUNTERS && y == 0u {
        counters[x] = 0u;
    }
    if x >= side || y >= side {
        return;
    }
    cell_hits[y * side + x] = vec4(0u);
    seen_through[y * side + x] = 0u;
    let old_x = i32(x) + move_window_params.shift_x;
    let old_y = i32(y) + move_window_params.shift_y;
    let stayed = old_x >= 0 && old_y >= 0 && old_x < i32(side) && old_y < i32(side);
    if !stayed || move_window_params.forget == 1u {
        let slot = slot_of(x, y, move_window_params.origin_slot_x, move_window_params.origin_slot_y, side);
        cells[slot] = from_cell(Cell(0.0, UNKNOWN, 0u, 0u));
    }
}
