// Clears what map reliability keeps of the looks at a cell.
@group(0) @binding(9) var<storage, read_write> cell_looks: array<array<vec4<f32>, 2>>;

fn forget_looks(slot: u32) {
    cell_looks[slot] = array(vec4(0.0), vec4(0.0));
}
