// Sums the plan map's costs over the cells that every trajectory crosses.
// spec 2 §5 (Eq. 12 of the paper).
struct SumParams {
    side: u32,
    quads: u32,             // words of four cells a row
    resolution_m: f32,
    candidates: u32,
    places: u32,            // per candidate
    unknown_cost: u32,      // of a cell that is unknown or outside of the map
}

@group(0) @binding(0) var<uniform> sum_params: SumParams;
@group(0) @binding(1) var<storage, read> plan_costs: array<u32>;
@group(0) @binding(2) var<storage, read> trajectories: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read_write> scores: array<vec4<u32>>;

const OUTSIDE = 0xffffffffu;
const COST_UNKNOWN = 255u;

// The cell at a place in the window; OUTSIDE where there is none.
fn cell_at(place: vec2<f32>) -> u32 {
    let at = place / sum_params.resolution_m;
    let side = sum_params.side;
    if !(at.x >= 0.0 && at.y >= 0.0 && at.x < f32(side) && at.y < f32(side)) {
        return OUTSIDE;
    }
    return min(u32(at.y), side - 1u) * side + min(u32(at.x), side - 1u);
}

fn cost_of(cell: u32) -> u32 {
    if cell == OUTSIDE {
        return COST_UNKNOWN;
    }
    let x = cell % sum_params.side;
    let word = plan_costs[cell / sum_params.side * sum_params.quads + x / 4u];
    return (word >> (8u * (x % 4u))) & 0xffu;
}

@compute @workgroup_size(64)
fn sum(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= sum_params.candidates {
        return;
    }
    var total = 0u;
    var worst = 0u;
    var cells = 0u;
    var unknown = 0u;
    var last = OUTSIDE - 1u;
    for (var place = 0u; place < sum_params.places; place++) {
        let cell = cell_at(trajectories[id.x * sum_params.places + place]);
        if cell != last {
            let cost = cost_of(cell);
            let known = cost != COST_UNKNOWN;
            total += select(sum_params.unknown_cost, cost, known);
            worst = max(worst, select(0u, cost, known));
            unknown += select(1u, 0u, known);
            cells += 1u;
            last = cell;
        }
    }
    scores[id.x] = vec4(total, worst, cells, unknown);
}
