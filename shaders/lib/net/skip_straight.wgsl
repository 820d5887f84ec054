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
