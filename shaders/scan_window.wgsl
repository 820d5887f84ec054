// Moves the window of the lidar map by whole cells and clears the sums of one scan.
// spec 2 §3 (transparent cells are kept in the map frame).
struct ScanWindowParams {
    side: u32,
    origin_slot_x: u32,     // slot of window cell (0, 0)
    origin_slot_y: u32,
    shift_x: i32,           // cells moved since the scan before
    shift_y: i32,
    forget: u32,            // 1: nothing is remembered
    layers: u32,
    pad: u32,
}

@group(0) @binding(0) var<uniform> scan_window_params: ScanWindowParams;
@group(0) @binding(1) var<storage, read_write> layer_sums: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read_write> sector_range: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> inflation: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read_write> remembered: array<u32>;

@compute @workgroup_size(64)
fn scan_window(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = scan_window_params.side;
    if id.x < SECTORS {
        sector_range[id.x] = vec2(0u);
    }
    if id.x >= side * side {
        return;
    }
    let layers = scan_window_params.layers;
    for (var layer = 0u; layer < layers; layer++) {
        layer_sums[id.x * layers + layer] = vec2(0u);
    }
    inflation[id.x] = vec2(0u);
    let x = id.x % side;
    let y = id.x / side;
    let old_x = i32(x) + scan_window_params.shift_x;
    let old_y = i32(y) + scan_window_params.shift_y;
    let stayed = old_x >= 0 && old_y >= 0 && old_x < i32(side) && old_y < i32(side);
    if !stayed || scan_window_params.forget == 1u {
        let slot = slot_of(x, y, scan_window_params.origin_slot_x, scan_window_params.origin_slot_y, side);
        remembered[slot] = 0u;
    }
}
