// A map cell as it is kept from frame to frame, and the hits of one frame (spec 1 §3).
const UNKNOWN = 0u;
const FREE = 1u;
const OCCUPIED = 2u;

// It is stored as vec4<u32>, which loads and stores in one go.
struct Cell {
    occupancy: f32,     // p; with fusion evidence A, what speaks for the cell (lib/fusion)
    state: u32,         // UNKNOWN, FREE or OCCUPIED in bits 0-1; consecutive hits in bits 8-15
    history: u32,       // one bit per observed frame, the newest lowest: 1 = hit; with fusion evidence B, what speaks against it
    top: u32,           // highest hit recorded, in steps above height_min; 0 = none
}

// What a frame leaves of a cell for the passes after it: its state in bits 0-1 (see_state), and these.
const WAS_HIT = 4u;
const WAS_SEEN_THROUGH = 8u;

fn see_state(word: u32) -> u32 {
    return word & 3u;
}

struct CellHits {
    count: u32,         // pixels that ended in the cell inside the height band
    weight: u32,        // sum of their weights, fixed point
    top: u32,           // highest of them, in steps above height_min; FLOOR where only the floor was met
    low: u32,           // lowest of them, in steps with all bits inverted; 0 where that is not kept
}

fn to_cell(v: vec4<u32>) -> Cell {
    return Cell(bitcast<f32>(v.x), v.y, v.z, v.w);
}

fn from_cell(cell: Cell) -> vec4<u32> {
    return vec4(bitcast<u32>(cell.occupancy), cell.state, cell.history, cell.top);
}

// Fixed-point scale of heights: 1/65536 m. 0 is kept for "none", FLOOR for a trusted floor point.
const FLOOR = 1u;
const HEIGHT_STEPS_PER_M = 65536.0;

fn height_to_steps(height_above_min_m: f32) -> u32 {
    return u32(clamp(height_above_min_m * HEIGHT_STEPS_PER_M, 0.0, 4.0e9)) + FLOOR + 1u;
}

fn steps_to_height(steps: u32) -> f32 {
    return f32(steps - FLOOR - 1u) / HEIGHT_STEPS_PER_M;
}
