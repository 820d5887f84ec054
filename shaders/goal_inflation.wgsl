// Spreads lethal cells over the cells that the kernel reaches from them: Eq. 10 as a scatter.
// spec 2 §4 (Eq. 8-10 of the paper), spec 4 §2 (inflation follows the verdict).
struct GoalInflationParams {
    side: u32,
    taps: u32,          // cells of the kernel
    inscribed: u32,     // how many of them, the first ones, lie within the robot's inscribed radius
    origin_slot_x: u32, // slot of window cell (0, 0) in the layers
    origin_slot_y: u32,
}

@group(0) @binding(0) var<uniform> goal_inflation_params: GoalInflationParams;
@group(0) @binding(1) var<storage, read> verdicts: array<u32>;
@group(0) @binding(2) var<storage, read> kernel_taps: array<u32>;
@group(0) @binding(3) var<storage, read_write> inflation: array<atomic<u32>>;

// Taps are two signed bytes, moved up by 128: x in bits 0-7, y in bits 8-15.
const TAP_ZERO = 128u;

// Set in a cell's word beside the sum of steps, which stays below it.
const INSCRIBED = 0x80000000u;

// Rows of the rule that a lidar decides.
const SOLID_ROW = 2u;
const TRANSPARENT_ROW = 3u;

// How strongly a cell is spread: fully where it is lethal, if no lidar says how much.
fn strength_of(x: u32, y: u32) -> u32 {
    let verdict = verdicts[y * goal_inflation_params.side + x];
    if verdict_cost(verdict) != COST_LETHAL {
        return 0u;
    }
    let row = verdict_row(verdict);
    return select(u32(INTENSITY_STEPS), lidar_strength(x, y), row == SOLID_ROW || row == TRANSPARENT_ROW);
}

@compute @workgroup_size(8, 8)
fn goal_inflation(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = goal_inflation_params.side;
    if id.x >= side || id.y >= side {
        return;
    }
    let amount = strength_of(id.x, id.y);
    let taps = select(0u, goal_inflation_params.taps, amount > 0u);
    for (var tap = 0u; tap < 65536u; tap++) {
        if tap >= taps {
            break;
        }
        let packed = kernel_taps[tap];
        // Below 0 these wrap to large numbers, which are out of the map too.
        let to_x = id.x + (packed & 0xffu) - TAP_ZERO;
        let to_y = id.y + ((packed >> 8u) & 0xffu) - TAP_ZERO;
        if to_x < side && to_y < side {
            let to = to_y * side + to_x;
            atomicAdd(&inflation[to], amount);
            if tap < goal_inflation_params.inscribed {
                atomicOr(&inflation[to], INSCRIBED);
            }
        }
    }
}
