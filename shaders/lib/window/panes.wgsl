// Clears the layer of panes of a cell.
@group(0) @binding(7) var<storage, read_write> pane_cells: array<vec2<u32>>;

fn forget_panes(slot: u32) {
    pane_cells[slot] = vec2(0u);
}
