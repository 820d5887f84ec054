// Makes lethal what lies between two occupied cells that face each other: gaps that the pixels' spacing leaves in a thing.
// spec 1 §9, step 7. Needs lib/verdict, the rows of the rule that bridge and that may be bridged.
struct BridgeGapsParams {
    side: u32,
    words: u32,     // 32-bit words a row
}

@group(0) @binding(0) var<uniform> bridge_gaps_params: BridgeGapsParams;
@group(0) @binding(1) var<storage, read> camera_bits: array<u32>;
@group(0) @binding(2) var<storage, read_write> verdicts: array<u32>;

// A word of bits and those beside each cell, towards smaller and larger x.
struct Strip {
    here: u32,
    smaller: u32,
    larger: u32,
}

fn bits_at(row: u32, word: u32) -> u32 {
    let words = bridge_gaps_params.words;
    let inside = row < bridge_gaps_params.side && word < words;
    return select(0u, camera_bits[select(0u, row * words + word, inside)], inside);
}

// Places before the first wrap around and lie outside, too.
fn strip_at(row: u32, word: u32) -> Strip {
    let here = bits_at(row, word);
    return Strip(here, (here << 1u) | (bits_at(row, word - 1u) >> 31u), (here >> 1u) | (bits_at(row, word + 1u) << 31u));
}

@compute @workgroup_size(64)
fn gaps(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = bridge_gaps_params.side;
    let words = bridge_gaps_params.words;
    if id.x >= side * words {
        return;
    }
    let row = id.x / words;
    let word = id.x % words;
    let before = strip_at(row - 1u, word);
    let now = strip_at(row, word);
    let after = strip_at(row + 1u, word);
    let across = (now.smaller & now.larger) | (before.here & after.here);
    let diagonal = (before.smaller & after.larger) | (before.larger & after.smaller);
    let gap = (across | diagonal) & ~now.here;
    let first = word * 32u;
    for (var i = firstTrailingBit(gap); i < min(32u, side - first); i++) {
        let cell = row * side + first + i;
        let may = ((BRIDGEABLE_ROWS >> verdict_row(verdicts[cell])) & 1u) != 0u;
        if may && ((gap >> i) & 1u) != 0u {
            // Sensor and age stay those of the cell.
            verdicts[cell] = (verdicts[cell] & ~0xfffu) | BRIDGED;
        }
    }
}
