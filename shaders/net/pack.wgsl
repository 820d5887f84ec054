// The network's input from planes of floats, as files have it, to a tensor of quads; missing channels are 0.
// Four pixels at a time: rows are multiples of four long.
@group(0) @binding(1) var<storage, read> planes: array<vec4<f32>>;

// Four pixels of one channel.
fn channel_at(word: i32, channel: i32) -> vec4<f32> {
    let value = planes[min(channel, CHANNELS - 1) * WIDTH * HEIGHT / 4 + word];
    return select(vec4(0.0), value, channel < CHANNELS);
}

@compute @workgroup_size(64)
fn pack(@builtin(global_invocation_id) id: vec3<u32>) {
    let word = i32(id.x);
    if word >= WIDTH * HEIGHT / 4 {
        return;
    }
    let quad = i32(id.y);
    let channels = mat4x4(
        channel_at(word, 4 * quad),
        channel_at(word, 4 * quad + 1),
        channel_at(word, 4 * quad + 2),
        channel_at(word, 4 * quad + 3),
    );
    let pixels = transpose(channels);
    let at = vec2(word % (WIDTH / 4) * 4, word / (WIDTH / 4));
    store_sink(at, quad, pixels[0]);
    store_sink(at + vec2(1, 0), quad, pixels[1]);
    store_sink(at + vec2(2, 0), quad, pixels[2]);
    store_sink(at + vec2(3, 0), quad, pixels[3]);
}
