// Keeps the farthest trusted depth of every TILE pixels of a strip, for see_through/tiles.
@group(0) @binding(6) var<storage, read_write> strip_far_m: array<f32>;

fn keep_far(word: u32, far_m: f32) {
    strip_far_m[word] = far_m;
}
