// Distance in cells to the nearest occupied cell of the same row, up to the radius, a byte each: first half of an exact transform.
// spec 1 §3 (inflation).
struct InflateRowsParams {
    side: u32,
    words: u32,
    radius: u32,    // cells, at most 254
    quads: u32,     // words of four cells a row
}

@group(0) @binding(0) var<uniform> inflate_rows_params: InflateRowsParams;
@group(0) @binding(1) var<storage, read> occupied_bits: array<u32>;
@group(0) @binding(2) var<storage, read_write> row_distance: array<u32>;

// Distance to the nearest set bit at or left of x, radius + 1 where there is none.
fn to_left(row: u32, x: u32) -> u32 {
    let none = inflate_rows_params.radius + 1u;
    let word = x / 32u;
    let bit = x % 32u;
    let here = occupied_bits[row * inflate_rows_params.words + word] << (31u - bit);
    if here != 0u {
        return min(countLeadingZeros(here), none);
    }
    for (var back = 1u; back <= word; back++) {
        let start = bit + 1u + (back - 1u) * 32u;
        if start >= none {
            break;
        }
        let bits = occupied_bits[row * inflate_rows_params.words + word - back];
        if bits != 0u {
            return min(start + countLeadingZeros(bits), none);
        }
    }
    return none;
}

// The same at or right of x.
fn to_right(row: u32, x: u32) -> u32 {
    let none = inflate_rows_params.radius + 1u;
    let word = x / 32u;
    let bit = x % 32u;
    let here = occupied_bits[row * inflate_rows_params.words + word] >> bit;
    if here != 0u {
        return min(countTrailingZeros(here), none);
    }
    for (var ahead = 1u; word + ahead < inflate_rows_params.words; ahead++) {
        let start = 32u - bit + (ahead - 1u) * 32u;
        if start >= none {
            break;
        }
        let bits = occupied_bits[row * inflate_rows_params.words + word + ahead];
        if bits != 0u {
            return min(start + countTrailingZeros(bits), none);
        }
    }
    return none;
}

@compute @workgroup_size(64)
fn rows(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = inflate_rows_params.side;
    let quads = inflate_rows_params.quads;
    if id.x >= side * quads {
        return;
    }
    let row = id.x / quads;
    let first = 4u * (id.x % quads);
    var packed = 0u;
    for (var i = 0u; i < 4u; i++) {
        let x = min(first + i, side - 1u);
        packed |= min(to_left(row, x), to_right(row, x)) << (8u * i);
    }
    row_distance[id.x] = packed;
}
