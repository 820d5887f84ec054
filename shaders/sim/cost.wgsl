// Matching cost: Hamming distances of census signatures, summed over five columns, at every disparity.
// spec 1 §8. An invocation does 8 pixels of a row at 8 disparities; two disparities share a word (the even one lowest).
struct SimCostParams {
    width: u32,             // a multiple of 8
    height: u32,
    disparity_words: u32,   // half the disparities; a multiple of 4
}

@group(0) @binding(0) var<uniform> cost_params: SimCostParams;
@group(0) @binding(1) var<storage, read> left_signature: array<vec2<u32>>;
@group(0) @binding(2) var<storage, read> right_signature: array<vec2<u32>>;
@group(0) @binding(3) var<storage, read_write> volume: array<vec4<u32>>;    // [row][eight columns][word of disparities][column]

// Signatures of twelve columns. Fields by name, not an array: drivers keep them in registers.
struct Columns {
    a: vec2<u32>, b: vec2<u32>, c: vec2<u32>, d: vec2<u32>, e: vec2<u32>, f: vec2<u32>,
    g: vec2<u32>, h: vec2<u32>, i: vec2<u32>, j: vec2<u32>, k: vec2<u32>, l: vec2<u32>,
}

// Distances of a left signature from two right ones, in one word.
fn distances(left: vec2<u32>, even: vec2<u32>, odd: vec2<u32>) -> u32 {
    let low = countOneBits(left ^ even);
    let high = countOneBits(left ^ odd);
    return (low.x + low.y) | ((high.x + high.y) << 16u);
}

// The twelve columns one further to the left, which `first` is.
fn shifted(old: Columns, first: vec2<u32>) -> Columns {
    return Columns(first, old.a, old.b, old.c, old.d, old.e, old.f, old.g, old.h, old.i, old.j, old.k);
}

// Sums over five columns for the eight pixels in the middle, at an even disparity and the next.
fn store_sums(at: u32, left: Columns, even: Columns, odd: Columns) {
    let a = distances(left.a, even.a, odd.a);
    let b = distances(left.b, even.b, odd.b);
    let c = distances(left.c, even.c, odd.c);
    let d = distances(left.d, even.d, odd.d);
    let e = distances(left.e, even.e, odd.e);
    let f = distances(left.f, even.f, odd.f);
    let g = distances(left.g, even.g, odd.g);
    let h = distances(left.h, even.h, odd.h);
    let i = distances(left.i, even.i, odd.i);
    let j = distances(left.j, even.j, odd.j);
    let k = distances(left.k, even.k, odd.k);
    let l = distances(left.l, even.l, odd.l);
    let s0 = a + b + c + d + e;
    let s1 = s0 + f - a;
    let s2 = s1 + g - b;
    let s3 = s2 + h - c;
    let s4 = s3 + i - d;
    let s5 = s4 + j - e;
    let s6 = s5 + k - f;
    let s7 = s6 + l - g;
    volume[at] = vec4(s0, s1, s2, s3);
    volume[at + 1u] = vec4(s4, s5, s6, s7);
}

// Beyond the left border there is nothing to match: the first column stands in, and the left-right check
// drops what matches it.
fn right_at(row: u32, x: i32) -> vec2<u32> {
    return right_signature[row + u32(clamp(x, 0, i32(cost_params.width) - 1))];
}

fn left_at(row: u32, x: i32) -> vec2<u32> {
    return left_signature[row + u32(clamp(x, 0, i32(cost_params.width) - 1))];
}

@compute @workgroup_size(8, 8)
fn cost(@builtin(global_invocation_id) id: vec3<u32>) {
    let width = cost_params.width;
    if id.x * 8u >= width || id.y >= cost_params.height || id.z * 4u >= cost_params.disparity_words {
        return;
    }
    let row = id.y * width;
    let x = i32(id.x * 8u) - 2;
    let r = x - i32(id.z * 8u);
    let left = Columns(
        left_at(row, x), left_at(row, x + 1), left_at(row, x + 2), left_at(row, x + 3),
        left_at(row, x + 4), left_at(row, x + 5), left_at(row, x + 6), left_at(row, x + 7),
        left_at(row, x + 8), left_at(row, x + 9), left_at(row, x + 10), left_at(row, x + 11),
    );
    let right0 = Columns(
        right_at(row, r), right_at(row, r + 1), right_at(row, r + 2), right_at(row, r + 3),
        right_at(row, r + 4), right_at(row, r + 5), right_at(row, r + 6), right_at(row, r + 7),
        right_at(row, r + 8), right_at(row, r + 9), right_at(row, r + 10), right_at(row, r + 11),
    );
    let right1 = shifted(right0, right_at(row, r - 1));
    let right2 = shifted(right1, right_at(row, r - 2));
    let right3 = shifted(right2, right_at(row, r - 3));
    let right4 = shifted(right3, right_at(row, r - 4));
    let right5 = shifted(right4, right_at(row, r - 5));
    let right6 = shifted(right5, right_at(row, r - 6));
    let right7 = shifted(right6, right_at(row, r - 7));
    let at = ((id.y * (width / 8u) + id.x) * cost_params.disparity_words + id.z * 4u) * 2u;
    store_sums(at, left, right0, right1);
    store_sums(at + 2u, left, right2, right3);
    store_sums(at + 4u, left, right4, right5);
    store_sums(at + 6u, left, right6, right7);
}
