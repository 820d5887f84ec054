// Joins what was spread around obstacles with the verdicts to costs in Nav2's scale, four cells a word.
// spec 2 §4 (Eq. 11 of the paper), spec 4 §2 (inflation follows the verdict).
struct GoalCostsParams {
    side: u32,
    quads: u32,             // words of four cells a row
}

@group(0) @binding(0) var<uniform> goal_costs_params: GoalCostsParams;
@group(0) @binding(1) var<storage, read> verdicts: array<u32>;
@group(0) @binding(2) var<storage, read> inflation: array<u32>;
@group(0) @binding(3) var<storage, read_write> costmap: array<u32>;

// Cost of an inflated cell: 1 to 252 by its value, 253 within the inscribed radius.
fn inflated_cost(steps: u32, inscribed: bool) -> u32 {
    return select(1u + 251u * steps / u32(INTENSITY_STEPS), COST_INSCRIBED, inscribed);
}

// No cost falls below that of the verdict, and unknown is overwritten only within the inscribed radius.
fn joined(verdict: u32, spread: u32) -> u32 {
    let base = verdict_cost(verdict);
    let steps = min(spread & 0x7fffffffu, u32(INTENSITY_STEPS));
    let cost = select(0u, inflated_cost(steps, spread > 0x7fffffffu), steps > 0u);
    if base == COST_UNKNOWN {
        return select(COST_UNKNOWN, cost, cost >= COST_INSCRIBED);
    }
    return max(base, cost);
}

@compute @workgroup_size(8, 8)
fn goal_costs(@builtin(global_invocation_id) id: vec3<u32>) {
    let quads = goal_costs_params.quads;
    let side = goal_costs_params.side;
    if id.x >= quads || id.y >= side {
        return;
    }
    let cells = vec4(id.y * side) + min(vec4(4u * id.x) + vec4(0u, 1u, 2u, 3u), vec4(side - 1u));
    let verdict = vec4(verdicts[cells.x], verdicts[cells.y], verdicts[cells.z], verdicts[cells.w]);
    let cost = vec4(
        joined(verdict.x, inflation[cells.x]),
        joined(verdict.y, inflation[cells.y]),
        joined(verdict.z, inflation[cells.z]),
        joined(verdict.w, inflation[cells.w]),
    );
    let at = id.y * quads + id.x;
    costmap[at] = cost.x | (cost.y << 8u) | (cost.z << 16u) | (cost.w << 24u);
    keep_classes(at, verdict, cost);
}
