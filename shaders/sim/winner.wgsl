// Winner takes all: sums costs over five rows, keeps the best disparity, fits it to a fraction of a pixel.
// spec 1 §8 (winner takes all, uniqueness). An invocation does 4 rows of a column.
struct SimWinnerParams {
    width: u32,
    height: u32,
    disparity_words: u32,   // two disparities each
    uniqueness: f32,        // the second best must cost more than the best by this share
    largest_cost: f32,      // costs above this are no match
}

@group(0) @binding(0) var<uniform> winner_params: SimWinnerParams;
@group(0) @binding(1) var<storage, read> volume: array<u32>;
@group(0) @binding(2) var<storage, read_write> disparity: array<f32>;

// Whether the left image's pixels are matched; else the right's, by the same costs and without the cuts.
override left: bool = true;

const ROWS = 4u;
const NONE = 65535u;
const UNMATCHED = 0x01360136u;      // five columns of 62 differing bits, twice

// The best disparity so far and what its fit and its uniqueness need.
struct Best {
    cost: u32,
    disparity: u32,
    before: u32,        // cost one disparity below it
    after: u32,         // and above
    second: u32,        // least cost more than one disparity away
    last: u32,          // cost at the disparity before this one
    least: u32,         // least cost before that
}

fn considered(best: Best, disparity: u32, cost: u32) -> Best {
    let better = cost < best.cost;
    let next = disparity == best.disparity + 1u;
    let beyond = disparity > best.disparity + 1u;
    var b = best;
    // The right image's disparities are whole pixels: nothing but the best is kept of them.
    if !left {
        b.disparity = select(best.disparity, disparity, better);
        b.cost = min(best.cost, cost);
        return b;
    }
    b.second = select(select(best.second, min(best.second, cost), beyond), best.least, better);
    b.after = select(select(best.after, cost, next), NONE, better);
    b.before = select(best.before, best.last, better);
    b.disparity = select(best.disparity, disparity, better);
    b.cost = min(best.cost, cost);
    b.least = min(best.least, best.last);
    b.last = cost;
    return b;
}

// Where the costs of a word of disparities at a column lie in a row; eight columns lie together.
fn place(word: u32, x: u32) -> u32 {
    return ((x >> 3u) * winner_params.disparity_words + word) * 8u + (x & 7u);
}

// Costs of two disparities in the row that begins at `start`, each over five columns. A right pixel's are those of the
// left pixels that lie a disparity further to the right.
fn costs_at(start: u32, word: u32, x: u32) -> u32 {
    if left {
        return volume[start + place(word, x)];
    }
    let last = winner_params.width - 1u;
    let even = x + 2u * word;
    let low = select(UNMATCHED, volume[start + place(word, min(even, last))], even <= last);
    let high = select(UNMATCHED, volume[start + place(word, min(even + 1u, last))], even < last);
    return (low & 0xffffu) | (high & 0xffff0000u);
}

// Where the two straight lines through the neighbours' costs meet: costs of this kind grow by the distance.
fn fitted(best: Best) -> f32 {
    let before = f32(best.before);
    let after = f32(best.after);
    let steeper = max(max(before, after) - f32(best.cost), 1.0);
    let inner = best.before != NONE && best.after != NONE;
    return f32(best.disparity) + select(0.0, 0.5 * (before - after) / steeper, inner);
}

fn considered_pair(best: Best, word: u32, costs: u32) -> Best {
    return considered(considered(best, 2u * word, costs & 0xffffu), 2u * word + 1u, costs >> 16u);
}

// A pixel's disparity, -1 where the match is ambiguous or poor.
fn chosen(best: Best) -> f32 {
    let unique = f32(best.cost) < (1.0 - winner_params.uniqueness) * f32(best.second);
    if !left {
        return f32(best.disparity);
    }
    return select(-1.0, fitted(best), unique && f32(best.cost) <= winner_params.largest_cost);
}

@compute @workgroup_size(64)
fn winner(@builtin(global_invocation_id) id: vec3<u32>) {
    let width = winner_params.width;
    let height = winner_params.height;
    let first_row = id.y * ROWS;
    if id.x >= width || first_row >= height {
        return;
    }
    // Variables by name, not arrays: drivers keep them in registers.
    let none = Best(NONE, 0u, NONE, NONE, NONE, NONE, NONE);
    var best0 = none;
    var best1 = none;
    var best2 = none;
    var best3 = none;
    let last = height - 1u;
    let row = width * winner_params.disparity_words;
    let row_a = (max(first_row, 2u) - 2u) * row;
    let row_b = (max(first_row, 1u) - 1u) * row;
    let row_c = first_row * row;
    let row_d = min(first_row + 1u, last) * row;
    let row_e = min(first_row + 2u, last) * row;
    let row_f = min(first_row + 3u, last) * row;
    let row_g = min(first_row + 4u, last) * row;
    let row_h = min(first_row + 5u, last) * row;
    for (var word = 0u; word < winner_params.disparity_words; word++) {
        let a = costs_at(row_a, word, id.x);
        let b = costs_at(row_b, word, id.x);
        let c = costs_at(row_c, word, id.x);
        let d = costs_at(row_d, word, id.x);
        let e = costs_at(row_e, word, id.x);
        let f = costs_at(row_f, word, id.x);
        let g = costs_at(row_g, word, id.x);
        let h = costs_at(row_h, word, id.x);
        let sum0 = a + b + c + d + e;
        let sum1 = sum0 + f - a;
        let sum2 = sum1 + g - b;
        best0 = considered_pair(best0, word, sum0);
        best1 = considered_pair(best1, word, sum1);
        best2 = considered_pair(best2, word, sum2);
        best3 = considered_pair(best3, word, sum2 + h - c);
    }
    let at = first_row * width + id.x;
    disparity[at] = chosen(best0);
    if first_row + 1u < height { disparity[at + width] = chosen(best1); }
    if first_row + 2u < height { disparity[at + 2u * width] = chosen(best2); }
    if first_row + 3u < height { disparity[at + 3u * width] = chosen(best3); }
}
