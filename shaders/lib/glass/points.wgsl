// A point of the upload (sensor::Point): x, y, z in metres and the intensity. Needs lib/points.
fn point_at(index: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(point_words(2u * index));
}

// Its time; ring, column << 16; return type, strength << 8; label.
fn rest_of_point(index: u32) -> vec4<u32> {
    return point_words(2u * index + 1u);
}
