// Clears the layer of drops of a cell.
@group(0) @binding(8) var<storage, read_write> drop_cells: array<vec4<u32>>;

fn forget_drops(slot: u32) {
    drop_cells[slot] = vec4(0u);
}
