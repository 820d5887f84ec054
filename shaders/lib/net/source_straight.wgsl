// The window as it lies in the source. Needs lib/net/window, lib/net/source_texture or source_buffer.
struct SourceWindow {
    window: Window,
}

fn source_window(first: vec2<i32>, window: Window) -> SourceWindow {
    return SourceWindow(window);
}

fn source_taps(at: ptr<function, SourceWindow>, quad: i32) -> Taps {
    var taps: Taps;
    for (var y = 0; y < TAPS_Y; y++) {
        for (var x = 0; x < TAPS_X; x++) {
            let inside = (*at).window.inside_x[x] * (*at).window.inside_y[y];
            taps[y * TAPS_X + x] = inside * load_source(vec2((*at).window.x[x], (*at).window.y[y]), quad);
        }
    }
    return taps;
}
