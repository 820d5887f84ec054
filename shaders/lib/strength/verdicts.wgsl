// How strongly a cell is spread, from its verdict: fully where it is lethal, if no lidar says how much (spec 4 §2). Needs lib/verdict, lib/scan.
@group(0) @binding(1) var<storage, read> verdicts: array<u32>;

fn strength_of(x: u32, y: u32) -> u32 {
    let verdict = verdicts[y * goal_inflation_params.side + x];
    if verdict_cost(verdict) != COST_LETHAL {
        return 0u;
    }
    let row = verdict_row(verdict);
    return select(u32(INTENSITY_STEPS), lidar_strength(x, y), row == SOLID_ROW || row == TRANSPARENT_ROW);
}

// Rows of the rule that a lidar decides.
const SOLID_ROW = 2u;
const TRANSPARENT_ROW = 3u;
