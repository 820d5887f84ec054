// Census transform, 9x7: a bit for each neighbour darker than the pixel; and how much grey varies in that window.
// spec 1 §8. Four pixels an invocation, side by side in vectors; images are a multiple of 8 pixels wide.
struct SimCensusParams {
    words: u32,         // of four pixels in a row
    height: u32,
}

@group(0) @binding(0) var<uniform> census_params: SimCensusParams;
@group(0) @binding(1) var<storage, read> grey: array<u32>;
@group(0) @binding(2) var<storage, read_write> signature: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> texture: array<f32>;

// Whether the deviation of grey is wanted too.
override left: bool = true;

struct Window {
    first: vec4<u32>,       // bits of the columns to the left, and of the middle column above
    second: vec4<u32>,      // of the others
    sum: vec4<u32>,
    squares: vec4<u32>,
}

fn bytes(word: u32) -> vec4<u32> {
    return vec4(word, word >> 8u, word >> 16u, word >> 24u) & vec4(255u);
}

fn with_column(bits: vec4<u32>, values: vec4<u32>, center: vec4<u32>) -> vec4<u32> {
    return (bits << vec4(1u)) | vec4<u32>(values < center);
}

// Three words of a row: columns 0 to 3, 4 to 7 and 8 to 11, of which the pixels are columns 4 to 7.
fn with_row(window: Window, a: u32, b: u32, c: u32, row: u32, center: vec4<u32>) -> Window {
    let v0 = bytes(a);
    let v1 = bytes((a >> 8u) | (b << 24u));
    let v2 = bytes((a >> 16u) | (b << 16u));
    let v3 = bytes((a >> 24u) | (b << 8u));
    let v4 = bytes(b);
    let v5 = bytes((b >> 8u) | (c << 24u));
    let v6 = bytes((b >> 16u) | (c << 16u));
    let v7 = bytes((b >> 24u) | (c << 8u));
    let v8 = bytes(c);
    var w = window;
    w.first = with_column(with_column(w.first, v0, center), v1, center);
    w.first = with_column(with_column(w.first, v2, center), v3, center);
    w.second = with_column(with_column(w.second, v5, center), v6, center);
    w.second = with_column(with_column(w.second, v7, center), v8, center);
    w.first = select(w.first, with_column(w.first, v4, center), row < 3u);
    w.second = select(w.second, with_column(w.second, v4, center), row > 3u);
    w.sum += v0 + v1 + v2 + v3 + v4 + v5 + v6 + v7 + v8;
    w.squares += v0 * v0 + v1 * v1 + v2 * v2 + v3 * v3 + v4 * v4 + v5 * v5 + v6 * v6 + v7 * v7 + v8 * v8;
    return w;
}

@compute @workgroup_size(16, 4)
fn census(@builtin(global_invocation_id) id: vec3<u32>) {
    let words = census_params.words;
    if id.x >= words || id.y >= census_params.height {
        return;
    }
    // Borders are repeated by whole words.
    let before = max(id.x, 1u) - 1u;
    let after = min(id.x + 1u, words - 1u);
    let center = bytes(grey[id.y * words + id.x]);
    var window = Window(vec4(0u), vec4(0u), vec4(0u), vec4(0u));
    for (var r = 0u; r < 7u; r++) {
        let y = u32(clamp(i32(id.y + r) - 3, 0, i32(census_params.height) - 1)) * words;
        window = with_row(window, grey[y + before], grey[y + id.x], grey[y + after], r, center);
    }
    let first = (id.y * words + id.x) * 4u;
    signature[first] = vec2(window.first.x, window.second.x);
    signature[first + 1u] = vec2(window.first.y, window.second.y);
    signature[first + 2u] = vec2(window.first.z, window.second.z);
    signature[first + 3u] = vec2(window.first.w, window.second.w);
    if left {
        let mean = vec4<f32>(window.sum) / 63.0;
        let deviation = sqrt(max(vec4<f32>(window.squares) / 63.0 - mean * mean, vec4(0.0)));
        texture[first] = deviation.x;
        texture[first + 1u] = deviation.y;
        texture[first + 2u] = deviation.z;
        texture[first + 3u] = deviation.w;
    }
}
