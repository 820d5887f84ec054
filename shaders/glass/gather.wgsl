// Lists the candidates in the order of their cells, so that the same scan gives the same list; of more than fit every
// n-th is taken. spec 3 §3.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(2) var<storage, read> beam_cells: array<u32>;
@group(0) @binding(3) var<storage, read> candidate_bits: array<u32>;
@group(0) @binding(4) var candidates: texture_storage_2d_array<rgba32float, write>;
@group(0) @binding(5) var<storage, read_write> found: Found;
@group(0) @binding(6) var<storage, read_write> scores: array<u32>;
@group(0) @binding(7) var<storage, read_write> glass_counters: array<u32>;

const LANES = 256u;

@compute @workgroup_size(LANES)
fn gather(@builtin(local_invocation_index) lane: u32) {
    let words = (glass_params.rows * glass_params.columns + 31u) / 32u;
    let each = (words + LANES - 1u) / LANES;
    let begin = min(lane * each, words);
    let end = min(begin + each, words);
    var count = 0u;
    for (var w = begin; w < end; w++) {
        count += countOneBits(candidate_bits[w]);
    }
    share_starts(lane, count);
    var number = starts[lane];
    let thinning = max((total + MOST_CANDIDATES - 1u) / MOST_CANDIDATES, 1u);
    for (var w = begin; w < end; w++) {
        var bits = candidate_bits[w];
        while bits != 0u {
            let place = 32u * w + countTrailingZeros(bits);
            bits &= bits - 1u;
            if number % thinning == 0u && number / thinning < MOST_CANDIDATES {
                let point = point_at(index_in(beam_cells[2u * place]));
                textureStore(candidates, candidate_texel(number / thinning), 0u, point);
            }
            number++;
        }
    }
    if lane == 0u {
        let listed = (total + thinning - 1u) / thinning;
        found.candidates = listed;
        found.panes = 0u;
        found.inliers = 0u;
        found.mirrors = 0u;
        glass_counters[COUNT_CANDIDATES] = total;
        glass_counters[COUNT_THINNED] = total - listed;
    }
    for (var k = lane; k < MOST_HYPOTHESES; k += LANES) {
        scores[k] = 0u;
    }
}
