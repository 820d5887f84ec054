// What a scan left in the map, cell by cell, in the values of its layers, for the host.
// spec 2 §3, §4: I_TP, I_FP, I_FN and I_inflate.
struct ScanValuesParams {
    side: u32,
    origin_slot_x: u32,
    origin_slot_y: u32,
    solid_value: f32,       // value of a layer that counts fully
}

@group(0) @binding(0) var<uniform> scan_values_params: ScanValuesParams;
@group(0) @binding(1) var<storage, read> solid_cells: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> obstacle_value: array<f32>;
@group(0) @binding(3) var<storage, read> inflation: array<u32>;
@group(0) @binding(5) var<storage, read_write> cell_values: array<vec4<f32>>;

@compute @workgroup_size(8, 8)
fn scan_values(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = scan_values_params.side;
    if id.x >= side || id.y >= side {
        return;
    }
    let cell = id.y * side + id.x;
    let slot = slot_of(id.x, id.y, scan_values_params.origin_slot_x, scan_values_params.origin_slot_y, side);
    let word = solid_cells[slot].x;
    let value = obstacle_value[cell];
    let pane = has_pane(slot);
    let solid = (word & 0xffu) == SOLID && !pane;
    let steps = min(inflation[cell] & 0x7fffffffu, u32(INTENSITY_STEPS));
    let glass = select((word >> GLASS_SHIFT) & GLASS_MASK, u32(INTENSITY_STEPS), pane);
    let per_step = scan_values_params.solid_value / INTENSITY_STEPS;
    let shares = vec2(f32(glass), f32(steps)) * per_step;
    cell_values[cell] = vec4(select(0.0, value, solid), select(value, 0.0, solid), shares);
}
