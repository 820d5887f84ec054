// Ends a block: ReLU, and the sums into the tensor `sink`, its quads counted from `quad` on. Needs
// lib/net/window, lib/net/sums, lib/net/sink_*.
fn store_pair(sums: ptr<function, Sums>, first: vec2<i32>, quad: i32, q: i32) {
    for (var i = 0; i < 2; i++) {
        if q + i < OUT_QUADS {
            for (var p = 0; p < PIXELS; p++) {
                let at = pixel_of_tile(first, p);
                if is_inside(at) && quad + q + i < SINK_QUADS {
                    store_sink(at, quad + q + i, max((*sums)[(q + i) * PIXELS + p], vec4(0.0)));
                }
            }
        }
    }
}

fn finish(sums: ptr<function, Sums>, first: vec2<i32>, quad: i32) {
    store_pair(sums, first, quad, 0);
    if OUT_QUADS > 2 { store_pair(sums, first, quad, 2); }
    if OUT_QUADS > 4 { store_pair(sums, first, quad, 4); }
    if OUT_QUADS > 6 { store_pair(sums, first, quad, 6); }
    if OUT_QUADS > 8 { store_pair(sums, first, quad, 8); }
    if OUT_QUADS > 10 { store_pair(sums, first, quad, 10); }
    if OUT_QUADS > 12 { store_pair(sums, first, quad, 12); }
    if OUT_QUADS > 14 { store_pair(sums, first, quad, 14); }
}
