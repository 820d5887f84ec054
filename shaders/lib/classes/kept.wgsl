// Classes of cells (map::CellClass), four a word, for the host. Needs lib/verdict, lib/scan.
@group(0) @binding(5) var<storage, read_write> cell_classes: array<u32>;

// Rows of the rule (spec 4 §2) by what they call a cell.
const GLASS_ROW = 1u;
const TRANSPARENT_ROW = 3u;
const PASSABLE_OVER_CAMERA_ROW = 4u;
const PASSABLE_ROW = 7u;

// Class of a cell by its verdict and, after inflation, its cost.
fn class_of(verdict: u32, cost: u32) -> u32 {
    let base = verdict_cost(verdict);
    let row = verdict_row(verdict);
    let is_clear = row == GLASS_ROW || row == TRANSPARENT_ROW;
    let is_passable = row == PASSABLE_OVER_CAMERA_ROW || row == PASSABLE_ROW;
    var kind = select(FREE, PASSABLE, is_passable);
    kind = select(kind, UNKNOWN, base == COST_UNKNOWN);
    kind = select(kind, INFLATED, cost != base);
    return select(kind, select(SOLID, TRANSPARENT, is_clear), base == COST_LETHAL);
}

fn keep_classes(at: u32, verdict: vec4<u32>, cost: vec4<u32>) {
    cell_classes[at] = class_of(verdict.x, cost.x)
        | (class_of(verdict.y, cost.y) << 8u)
        | (class_of(verdict.z, cost.z) << 16u)
        | (class_of(verdict.w, cost.w) << 24u);
}
