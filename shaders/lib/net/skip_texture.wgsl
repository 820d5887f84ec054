// The tensor `skip` as a texture: quad l of channels is layer l.
@group(0) @binding(2) var skip: texture_storage_2d_array<rgba32float, read>;

fn load_skip(p: vec2<i32>, quad: i32) -> vec4<f32> {
    return textureLoad(skip, p, quad);
}
