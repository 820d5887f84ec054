// A full 3x3 convolution with bias and ReLU, to OUT_QUADS quads of outputs for each row of the grid.
// spec 1 §1 (stem). A row of weights for each tap of each quad of inputs.
fn add_full_tap(
    sums: ptr<function, Sums>,
    taps: ptr<function, Taps>,
    row: i32,
    first_quad: i32,
    tap: i32,
    channels: i32,
) {
    var inputs: Tile;
    for (var p = 0; p < PIXELS; p++) {
        let at = (STRIDE * (p / TILE_X) + tap / 3) * TAPS_X + STRIDE * (p % TILE_X) + tap % 3;
        inputs[p] = (*taps)[at];
    }
    add_quad(sums, &inputs, row + tap, 4 * first_quad, channels);
}

fn add_taps(sums: ptr<function, Sums>, at: ptr<function, SourceWindow>, quad: i32, first_quad: i32, channels: i32) {
    var taps = source_taps(at, quad);
    let row = 9 * quad;
    add_full_tap(sums, &taps, row, first_quad, 0, channels);
    add_full_tap(sums, &taps, row, first_quad, 1, channels);
    add_full_tap(sums, &taps, row, first_quad, 2, channels);
    add_full_tap(sums, &taps, row, first_quad, 3, channels);
    add_full_tap(sums, &taps, row, first_quad, 4, channels);
    add_full_tap(sums, &taps, row, first_quad, 5, channels);
    add_full_tap(sums, &taps, row, first_quad, 6, channels);
    add_full_tap(sums, &taps, row, first_quad, 7, channels);
    add_full_tap(sums, &taps, row, first_quad, 8, channels);
}

@compute @workgroup_size(64)
fn convolve(@builtin(global_invocation_id) id: vec3<u32>) {
    find_lane();
    let first = first_of_tile(id.x);
    let first_quad = i32(id.y) * OUT_QUADS;
    var at = source_window(first, window_at(first));
    var sums: Sums;
    start_sums(&sums, 9 * SOURCE_QUADS, first_quad);
    for (var quad = 0; quad < SOURCE_CHANNELS / 4; quad++) {
        add_taps(&sums, &at, quad, first_quad, 4);
    }
    if SOURCE_CHANNELS % 4 != 0 {
        add_taps(&sums, &at, SOURCE_CHANNELS / 4, first_quad, SOURCE_CHANNELS % 4);
    }
    finish(&sums, first, first_quad);
}
