// Whether a frame shows the ground in a cell, and nothing that stands there. Needs lib/cell.
@group(0) @binding(3) var<storage, read> cell_hits: array<CellHits>;

fn is_ground(cell: u32) -> bool {
    return cell_hits[cell].top == FLOOR;
}
