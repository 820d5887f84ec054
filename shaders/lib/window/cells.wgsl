// Clears the occupancy of a cell. Needs lib/cell.
@group(0) @binding(1) var<storage, read_write> cells: array<vec4<u32>>;

fn forget_cameras(slot: u32) {
    cells[slot] = from_cell(Cell(0.0, UNKNOWN, 0u, 0u));
}
