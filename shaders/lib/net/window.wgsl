// The window of taps around a tile of TILE_X x TILE_Y outputs. Needs the constants of a block alone (network::kernels).
// Where its columns and rows lie, and which of them are outside the image, where convolutions see zeros.
const PIXELS = TILE_X * TILE_Y;
const TAPS_X = STRIDE * (TILE_X - 1) + 3;
const TAPS_Y = STRIDE * (TILE_Y - 1) + 3;
alias Taps = array<vec4<f32>, TAPS_X * TAPS_Y>;
alias Tile = array<vec4<f32>, PIXELS>;

// Columns and rows before the stride.
const TAPPED = STRIDE * vec2(WIDTH, HEIGHT);

struct Window {
    x: array<i32, TAPS_X>,
    y: array<i32, TAPS_Y>,
    inside_x: array<f32, TAPS_X>,       // 1 inside the image, else 0
    inside_y: array<f32, TAPS_Y>,
}

fn window_at(first: vec2<i32>) -> Window {
    var window: Window;
    for (var i = 0; i < TAPS_X; i++) {
        let x = STRIDE * first.x - 1 + i;
        window.x[i] = clamp(x, 0, TAPPED.x - 1);
        window.inside_x[i] = select(0.0, 1.0, x >= 0 && x < TAPPED.x);
    }
    for (var i = 0; i < TAPS_Y; i++) {
        let y = STRIDE * first.y - 1 + i;
        window.y[i] = clamp(y, 0, TAPPED.y - 1);
        window.inside_y[i] = select(0.0, 1.0, y >= 0 && y < TAPPED.y);
    }
    return window;
}

fn first_of_tile(index: u32) -> vec2<i32> {
    // Invocations past the last tile repeat it, so that every lane of a subgroup takes part.
    let tile = min(i32(index), TILES_X * TILES_Y - 1);
    return vec2(tile % TILES_X * TILE_X, tile / TILES_X * TILE_Y);
}

// Whether pixel `p` of the tile lies in the image: the last tiles may stand over.
fn pixel_of_tile(first: vec2<i32>, p: i32) -> vec2<i32> {
    return first + vec2(p % TILE_X, p / TILE_X);
}

fn is_inside(at: vec2<i32>) -> bool {
    return at.x < WIDTH && at.y < HEIGHT;
}
