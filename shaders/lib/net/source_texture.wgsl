// The tensor `source` as a texture: quad l of channels is layer l.
@group(0) @binding(1) var source: texture_storage_2d_array<rgba32float, read>;

fn load_source(p: vec2<i32>, quad: i32) -> vec4<f32> {
    return textureLoad(source, p, quad);
}
