// Running sums of OUT_QUADS quads of outputs over the PIXELS of a tile. Needs lib/net/lanes_*, lib/net/window.
// Two quads at a time: drivers unroll short loops only, and an array indexed in a loop that stays is slow memory.
alias Sums = array<vec4<f32>, OUT_QUADS * PIXELS>;

// Sets quads `q` and `q + 1` to the biases at texels `k` and `k + 1`.
fn start_pair(sums: ptr<function, Sums>, biases: Eight, q: i32, k: i32) {
    for (var i = 0; i < 2; i++) {
        if q + i < OUT_QUADS {
            let bias = texel(biases, k + i);
            for (var p = 0; p < PIXELS; p++) {
                (*sums)[(q + i) * PIXELS + p] = bias;
            }
        }
    }
}

// Adds one quad of inputs to quads `q` and `q + 1` of outputs; from texel `at` on, four texels for each quad of
// outputs are the weights of the four inputs. Only the first `channels` inputs count.
fn add_pair(sums: ptr<function, Sums>, inputs: ptr<function, Tile>, row: i32, at: i32, q: i32, channels: i32) {
    let eight = load_eight(row, at + 4 * q);
    for (var i = 0; i < 2; i++) {
        if q + i < OUT_QUADS {
            let x = texel(eight, 4 * i);
            let y = texel(eight, 4 * i + 1);
            let z = texel(eight, 4 * i + 2);
            let w = texel(eight, 4 * i + 3);
            for (var p = 0; p < PIXELS; p++) {
                let v = (*inputs)[p];
                var sum = fma(v.xxxx, x, (*sums)[(q + i) * PIXELS + p]);
                if channels > 1 {
                    sum = fma(v.yyyy, y, sum);
                }
                if channels > 2 {
                    sum = fma(v.zzzz, z, sum);
                }
                if channels > 3 {
                    sum = fma(v.wwww, w, sum);
                }
                (*sums)[(q + i) * PIXELS + p] = sum;
            }
        }
    }
}

fn start_sums(sums: ptr<function, Sums>, row: i32, first: i32) {
    let low = load_eight(row, first);
    start_pair(sums, low, 0, 0);
    if OUT_QUADS > 2 { start_pair(sums, low, 2, 2); }
    if OUT_QUADS > 4 { start_pair(sums, low, 4, 4); }
    if OUT_QUADS > 6 { start_pair(sums, low, 6, 6); }
    if OUT_QUADS > 8 {
        let high = load_eight(row, first + 8);
        start_pair(sums, high, 8, 0);
        if OUT_QUADS > 10 { start_pair(sums, high, 10, 2); }
        if OUT_QUADS > 12 { start_pair(sums, high, 12, 4); }
        if OUT_QUADS > 14 { start_pair(sums, high, 14, 6); }
    }
}

fn add_quad(sums: ptr<function, Sums>, inputs: ptr<function, Tile>, row: i32, at: i32, channels: i32) {
    add_pair(sums, inputs, row, at, 0, channels);
    if OUT_QUADS > 2 { add_pair(sums, inputs, row, at, 2, channels); }
    if OUT_QUADS > 4 { add_pair(sums, inputs, row, at, 4, channels); }
    if OUT_QUADS > 6 { add_pair(sums, inputs, row, at, 6, channels); }
    if OUT_QUADS > 8 { add_pair(sums, inputs, row, at, 8, channels); }
    if OUT_QUADS > 10 { add_pair(sums, inputs, row, at, 10, channels); }
    if OUT_QUADS > 12 { add_pair(sums, inputs, row, at, 12, channels); }
    if OUT_QUADS > 14 { add_pair(sums, inputs, row, at, 14, channels); }
}
