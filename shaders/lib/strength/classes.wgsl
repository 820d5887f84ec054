// How strongly a cell is spread, from the classes of one scan. Needs lib/scan.
@group(0) @binding(1) var<storage, read> cell_class: array<u32>;

fn strength_of(x: u32, y: u32) -> u32 {
    return cell_class[y * goal_inflation_params.side + x] >> STRENGTH_SHIFT;
}
