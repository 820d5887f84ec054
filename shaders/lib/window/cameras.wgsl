// Clears the occupancy layer of a cell. Needs lib/cell.
@group(0) @binding(1) var<storage, read_write> cells: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read_write> cell_marks: array<vec2<u32>>;

fn forget_cameras(slot: u32) {
    cells[slot] = from_cell(Cell(0.0, UNKNOWN, 0u, 0u));
    cell_marks[slot] = vec2(0u);
}
