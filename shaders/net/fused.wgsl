// One block of the network in one pass: upsampling, concatenation with the skip, depthwise 3x3, pointwise 1x1.
// spec 1 §1.

// The window as it lies in the skip.
fn skip_taps(at: ptr<function, Window>, quad: i32) -> Taps {
    var taps: Taps;
    for (var y = 0; y < TAPS_Y; y++) {
        for (var x = 0; x < TAPS_X; x++) {
            let inside = (*at).inside_x[x] * (*at).inside_y[y];
            taps[y * TAPS_X + x] = inside * load_skip(vec2((*at).x[x], (*at).y[y]), quad);
        }
    }
    return taps;
}

@compute @workgroup_size(64)
fn fused(@builtin(global_invocation_id) id: vec3<u32>) {
    find_lane();
    let first = first_of_tile(id.x);
    var window = window_at(first);
    var source_at = source_window(first, window);
    var sums: Sums;
    start_sums(&sums, SOURCE_QUADS + SKIP_QUADS, 0);
    for (var quad = 0; quad < SOURCE_QUADS; quad++) {
        var taps = source_taps(&source_at, quad);
        var inputs = depthwise_tile(&taps, quad);
        add_quad(&sums, &inputs, quad, 16, 4);
    }
    for (var quad = 0; quad < SKIP_QUADS; quad++) {
        var taps = skip_taps(&window, quad);
        var inputs = depthwise_tile(&taps, SOURCE_QUADS + quad);
        add_quad(&sums, &inputs, SOURCE_QUADS + quad, 16, 4);
    }
    finish(&sums, first, 0);
}
