// Strength of a cell in the solidity layer. Needs lib/scan, lib/slot.
@group(0) @binding(4) var<storage, read> solid_cells: array<vec4<u32>>;

fn lidar_strength(x: u32, y: u32) -> u32 {
    let slot = slot_of(
        x,
        y,
        goal_inflation_params.origin_slot_x,
        goal_inflation_params.origin_slot_y,
        goal_inflation_params.side,
    );
    return solid_cells[slot].x >> STRENGTH_SHIFT;
}
