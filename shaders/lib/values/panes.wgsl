// Whether a pane crosses the cell.
@group(0) @binding(4) var<storage, read> pane_cells: array<vec2<u32>>;

fn has_pane(slot: u32) -> bool {
    return pane_cells[slot].y != 0u;
}
