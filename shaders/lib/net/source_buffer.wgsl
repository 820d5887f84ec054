// The tensor `source` as a buffer: plane l holds quad l of channels, row by row.
@group(0) @binding(1) var<storage, read> source: array<vec4<f32>>;

fn load_source(p: vec2<i32>, quad: i32) -> vec4<f32> {
    return source[(quad * SOURCE_HEIGHT + p.y) * SOURCE_WIDTH + p.x];
}
