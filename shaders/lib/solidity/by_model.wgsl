// A cell is solid unless the pass solidity/judge found that a robot can pass what stands there, or it is glass. Needs the
// parameters of intensity_classes.
@group(0) @binding(10) var<storage, read> passable_cells: array<u32>;

fn is_solid(cell: u32, value: f32, glass: bool) -> bool {
    return passable_cells[cell] == 0u && !glass;
}

// However bright it is.
fn solid_strength(value: f32) -> f32 {
    return intensity_classes_params.solid_value;
}
