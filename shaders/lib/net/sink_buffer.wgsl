// The tensor `sink` as a buffer: plane l holds quad l of channels, row by row.
@group(0) @binding(3) var<storage, read_write> sink: array<vec4<f32>>;

fn store_sink(p: vec2<i32>, quad: i32, value: vec4<f32>) {
    sink[(quad * HEIGHT + p.y) * WIDTH + p.x] = value;
}
