// The window in the source upsampled twofold, bilinearly. Needs lib/net/window, lib/net/source_texture or source_buffer.
// Pixel centres are aligned to corners of none: output 2m lies a quarter before source m, 2m + 1 a quarter behind it; the
// border is repeated.
const FROM_X = TILE_X / 2 + 2;
const FROM_Y = TILE_Y / 2 + 2;

struct SourceWindow {
    x: array<i32, FROM_X>,
    y: array<i32, FROM_Y>,
    inside_x: array<f32, TAPS_X>,
    inside_y: array<f32, TAPS_Y>,
}

fn source_window(first: vec2<i32>, window: Window) -> SourceWindow {
    var at: SourceWindow;
    for (var i = 0; i < FROM_X; i++) {
        at.x[i] = clamp(first.x / 2 - 1 + i, 0, SOURCE_WIDTH - 1);
    }
    for (var i = 0; i < FROM_Y; i++) {
        at.y[i] = clamp(first.y / 2 - 1 + i, 0, SOURCE_HEIGHT - 1);
    }
    at.inside_x = window.inside_x;
    at.inside_y = window.inside_y;
    return at;
}

// Between `a` and `b`, a quarter from `b` where `i` is odd, else from `a`.
fn between(a: vec4<f32>, b: vec4<f32>, i: i32) -> vec4<f32> {
    let share = select(0.25, 0.75, i % 2 == 1);
    return fma(b, vec4(share), a * (1.0 - share));
}

fn source_taps(at: ptr<function, SourceWindow>, quad: i32) -> Taps {
    var wide: array<vec4<f32>, TAPS_X * FROM_Y>;
    for (var y = 0; y < FROM_Y; y++) {
        var row: array<vec4<f32>, FROM_X>;
        for (var x = 0; x < FROM_X; x++) {
            row[x] = load_source(vec2((*at).x[x], (*at).y[y]), quad);
        }
        for (var x = 0; x < TAPS_X; x++) {
            wide[y * TAPS_X + x] = (*at).inside_x[x] * between(row[x / 2], row[x / 2 + 1], x);
        }
    }
    var taps: Taps;
    for (var y = 0; y < TAPS_Y; y++) {
        for (var x = 0; x < TAPS_X; x++) {
            let above = wide[y / 2 * TAPS_X + x];
            let below = wide[(y / 2 + 1) * TAPS_X + x];
            taps[y * TAPS_X + x] = (*at).inside_y[y] * between(above, below, y);
        }
    }
    return taps;
}
