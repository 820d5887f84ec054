// The tensor `sink` as a texture: quad l of channels is layer l.
@group(0) @binding(3) var sink: texture_storage_2d_array<rgba32float, write>;

fn store_sink(p: vec2<i32>, quad: i32, value: vec4<f32>) {
    textureStore(sink, p, quad, value);
}
