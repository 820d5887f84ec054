// Nav2 costs by the distance to the nearest occupied cell: second half of the transform, four cells a word.
// spec 1 §3 (inflation): unknown is overwritten only from 253 up.
struct InflateColumnsParams {
    side: u32,
    radius: u32,    // cells
}

@group(0) @binding(0) var<uniform> inflate_columns_params: InflateColumnsParams;
@group(0) @binding(1) var<storage, read> state: array<u32>;
@group(0) @binding(2) var<storage, read> row_distance: array<u32>;
@group(0) @binding(3) var<storage, read> cost_by_squared_distance: array<u32>;
@group(0) @binding(4) var<storage, read_write> costmap: array<u32>;

const COST_UNKNOWN = 255u;
const COST_INSCRIBED = 253u;

fn squared_distance(x: u32, y: u32) -> u32 {
    let side = inflate_columns_params.side;
    let radius = inflate_columns_params.radius;
    let none = (radius + 1u) * (radius + 1u);
    var best = none;
    let first = select(0u, y - radius, y > radius);
    let last = min(y + radius, side - 1u);
    for (var row = first; row <= last; row++) {
        let dx = row_distance[row * side + x];
        let dy = max(row, y) - min(row, y);
        best = min(best, dx * dx + dy * dy);
    }
    return best;
}

fn cost_of(i: u32) -> u32 {
    let side = inflate_columns_params.side;
    if i >= side * side {
        return 0u;
    }
    let radius = inflate_columns_params.radius;
    let squared = squared_distance(i % side, i / side);
    var cost = 0u;
    if squared <= radius * radius {
        cost = cost_by_squared_distance[squared];
    }
    return select(cost, COST_UNKNOWN, state[i] == UNKNOWN && cost < COST_INSCRIBED);
}

@compute @workgroup_size(64)
fn columns(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = inflate_columns_params.side;
    let first = 4u * id.x;
    if first >= side * side {
        return;
    }
    costmap[id.x] =
        cost_of(first) | (cost_of(first + 1u) << 8u) | (cost_of(first + 2u) << 16u) | (cost_of(first + 3u) << 24u);
}
