// A map in which nobody asks at which heights beams crossed: they are not known. Needs Place of intensity_classes.
fn beams_across(place: Place, lidar_height_m: f32) -> vec2<u32> {
    return vec2(0u);
}
