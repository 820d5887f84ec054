// No skip: the block takes its source alone.
fn load_skip(p: vec2<i32>, quad: i32) -> vec4<f32> {
    return vec4(0.0);
}
