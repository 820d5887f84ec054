// Eight neighbouring texels of weights, each read by every invocation that needs it. Needs lib/net/weights_*.
struct Eight {
    row: i32,
    first: i32,
}

fn find_lane() {}

fn load_eight(row: i32, first: i32) -> Eight {
    return Eight(row, first);
}

fn texel(eight: Eight, k: i32) -> vec4<f32> {
    return load_weights(eight.row, eight.first + k);
}
