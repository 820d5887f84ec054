// The weights of a block as a buffer: a row for each quad of input channels, then the row of output biases.
@group(0) @binding(0) var<storage, read> weights: array<vec4<f32>>;

fn load_weights(row: i32, at: i32) -> vec4<f32> {
    return weights[row * WEIGHTS_WIDTH + at];
}
