// Nav2 costs by the distance to the nearest lethal cell: second half of the transform, four cells a word.
// spec 1 §3 (inflation), spec 4 §2: no cost falls below that of the verdict, and unknown is overwritten only from 253 up.
struct InflateColumnsParams {
    side: u32,
    radius: u32,    // cells, at most 254
    quads: u32,     // words of four cells a row
    pad: u32,
}

@group(0) @binding(0) var<uniform> inflate_columns_params: InflateColumnsParams;
@group(0) @binding(1) var<storage, read> verdicts: array<u32>;
@group(0) @binding(2) var<storage, read> row_distance: array<u32>;
@group(0) @binding(3) var<storage, read> cost_by_squared_distance: array<u32>;
@group(0) @binding(4) var<storage, read_write> costmap: array<u32>;

// Squared distances of the four cells of a word.
fn squared_distances(quad: u32, y: u32) -> vec4<u32> {
    let radius = inflate_columns_params.radius;
    var best = vec4((radius + 1u) * (radius + 1u));
    let first = max(y, radius) - radius;
    let last = min(y + radius, inflate_columns_params.side - 1u);
    for (var row = first; row <= last; row++) {
        let word = row_distance[row * inflate_columns_params.quads + quad];
        let dx = (vec4(word) >> vec4(0u, 8u, 16u, 24u)) & vec4(0xffu);
        let dy = max(row, y) - min(row, y);
        best = min(best, dx * dx + vec4(dy * dy));
    }
    return best;
}

fn cost_of(squared: u32, verdict: u32) -> u32 {
    let radius = inflate_columns_params.radius;
    var cost = 0u;
    if squared <= radius * radius {
        cost = cost_by_squared_distance[squared];
    }
    let base = verdict_cost(verdict);
    if base == COST_UNKNOWN {
        return select(COST_UNKNOWN, cost, cost >= COST_INSCRIBED);
    }
    return max(base, cost);
}

@compute @workgroup_size(64)
fn columns(@builtin(global_invocation_id) id: vec3<u32>) {
    let quads = inflate_columns_params.quads;
    if id.x >= inflate_columns_params.side * quads {
        return;
    }
    let quad = id.x % quads;
    let y = id.x / quads;
    let squared = squared_distances(quad, y);
    let side = inflate_columns_params.side;
    let cells = vec4(y * side) + min(vec4(4u * quad) + vec4(0u, 1u, 2u, 3u), vec4(side - 1u));
    let verdict = vec4(verdicts[cells.x], verdicts[cells.y], verdicts[cells.z], verdicts[cells.w]);
    let cost = vec4(
        cost_of(squared.x, verdict.x),
        cost_of(squared.y, verdict.y),
        cost_of(squared.z, verdict.z),
        cost_of(squared.w, verdict.w),
    );
    costmap[id.x] = cost.x | (cost.y << 8u) | (cost.z << 16u) | (cost.w << 24u);
    keep_classes(id.x, verdict, cost);
}
