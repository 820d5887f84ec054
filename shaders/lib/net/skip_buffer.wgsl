// The tensor `skip` as a buffer: plane l holds quad l of channels, row by row.
@group(0) @binding(2) var<storage, read> skip: array<vec4<f32>>;

fn load_skip(p: vec2<i32>, quad: i32) -> vec4<f32> {
    return skip[(quad * SKIP_HEIGHT + p.y) * SKIP_WIDTH + p.x];
}
