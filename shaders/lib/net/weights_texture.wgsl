// The weights of a block as a texture: a row for each quad of input channels, then the row of output biases.
@group(0) @binding(0) var weights: texture_storage_2d_array<rgba32float, read>;

fn load_weights(row: i32, at: i32) -> vec4<f32> {
    return textureLoad(weights, vec2(at, row), 0);
}
