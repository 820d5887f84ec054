// Depthwise 3x3 of one quad of channels over a tile, with bias and ReLU. Needs lib/net/lanes_*, lib/net/window.
fn add_tap(sums: ptr<function, Tile>, taps: ptr<function, Taps>, weight: vec4<f32>, x: i32, y: i32) {
    for (var p = 0; p < PIXELS; p++) {
        let at = (STRIDE * (p / TILE_X) + y) * TAPS_X + STRIDE * (p % TILE_X) + x;
        (*sums)[p] = fma(weight, (*taps)[at], (*sums)[p]);
    }
}

// In a row of weights, texels 0 to 8 are the taps, 9 is the bias.
fn depthwise_tile(taps: ptr<function, Taps>, row: i32) -> Tile {
    let first = load_eight(row, 0);
    let second = load_eight(row, 8);
    var sums: Tile;
    let bias = texel(second, 1);
    for (var p = 0; p < PIXELS; p++) {
        sums[p] = bias;
    }
    add_tap(&sums, taps, texel(first, 0), 0, 0);
    add_tap(&sums, taps, texel(first, 1), 1, 0);
    add_tap(&sums, taps, texel(first, 2), 2, 0);
    add_tap(&sums, taps, texel(first, 3), 0, 1);
    add_tap(&sums, taps, texel(first, 4), 1, 1);
    add_tap(&sums, taps, texel(first, 5), 2, 1);
    add_tap(&sums, taps, texel(first, 6), 0, 2);
    add_tap(&sums, taps, texel(first, 7), 1, 2);
    add_tap(&sums, taps, texel(second, 0), 2, 2);
    for (var p = 0; p < PIXELS; p++) {
        sums[p] = max(sums[p], vec4(0.0));
    }
    return sums;
}
