// Ends the last block: ReLU, then the head (1x1 convolution to one channel, sigmoid) into `reliability_low`. Needs
// lib/net/weights_*, lib/net/window, lib/net/sums, lib/net/sigmoid.
// Its weights are the row behind the biases: a texel for each quad, then its own bias.
@group(0) @binding(3) var<storage, read_write> reliability_low: array<f32>;

fn finish(sums: ptr<function, Sums>, first: vec2<i32>, quad: i32) {
    let row = SOURCE_QUADS + SKIP_QUADS + 1;
    var logits: array<f32, PIXELS>;
    let bias = load_weights(row, OUT_QUADS).x;
    for (var p = 0; p < PIXELS; p++) {
        logits[p] = bias;
    }
    for (var q = 0; q < OUT_QUADS; q++) {
        let weight = load_weights(row, q);
        for (var p = 0; p < PIXELS; p++) {
            logits[p] += dot(weight, max((*sums)[q * PIXELS + p], vec4(0.0)));
        }
    }
    for (var p = 0; p < PIXELS; p++) {
        let at = pixel_of_tile(first, p);
        if is_inside(at) {
            reliability_low[at.y * WIDTH + at.x] = reliability_of(logits[p]);
        }
    }
}
