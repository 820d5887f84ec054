// Marks a cell in the classes of this scan. Needs lib/scan.
@group(0) @binding(2) var<storage, read_write> cell_class: array<u32>;

// The `number` in the list of the pane that crosses the cell; KEPT_PANES: none.
fn keep_pane(x: u32, y: u32, number: u32) {
    if number < KEPT_PANES {
        let steps = u32(INTENSITY_STEPS);
        cell_class[y * pane_cells_params.side + x] = TRANSPARENT | (steps << GLASS_SHIFT) | (steps << STRENGTH_SHIFT);
    }
}
