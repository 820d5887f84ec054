// Clears the solidity layer of a cell.
@group(0) @binding(6) var<storage, read_write> solid_cells: array<vec4<u32>>;

fn forget_lidars(slot: u32) {
    solid_cells[slot] = vec4(0u);
}
