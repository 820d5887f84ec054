// Moves the window by whole cells: cells that stay keep their state, new ones start unknown; clears the frame's sums.
// spec 1 §3 (local map), spec 4 §2 (all layers share the window).
struct MoveWindowParams {
    side: u32,
    origin_slot_x: u32,     // slot of window cell (0, 0)
    origin_slot_y: u32,
    shift_x: i32,           // cells moved since the message before
    shift_y: i32,
    forget: u32,            // 1: every cell starts unknown
}

@group(0) @binding(0) var<uniform> move_window_params: MoveWindowParams;

@compute @workgroup_size(16, 4)
fn move_window(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = move_window_params.side;
    let x = id.x;
    let y = id.y;
    if y == 0u {
        clear_counter(x);
    }
    if x >= side || y >= side {
        return;
    }
    clear_sums(y * side + x);
    let old_x = i32(x) + move_window_params.shift_x;
    let old_y = i32(y) + move_window_params.shift_y;
    let stayed = old_x >= 0 && old_y >= 0 && old_x < i32(side) && old_y < i32(side);
    if !stayed || move_window_params.forget == 1u {
        let slot = slot_of(x, y, move_window_params.origin_slot_x, move_window_params.origin_slot_y, side);
        forget_cameras(slot);
        forget_looks(slot);
        forget_lidars(slot);
        forget_panes(slot);
        forget_drops(slot);
    }
}
