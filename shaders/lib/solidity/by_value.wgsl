// A cell is solid by its intensity: a layer above Gamma. Needs the parameters of intensity_classes.
fn is_solid(cell: u32, value: f32, glass: bool) -> bool {
    return value > intensity_classes_params.gamma;
}

fn solid_strength(value: f32) -> f32 {
    return value;
}
