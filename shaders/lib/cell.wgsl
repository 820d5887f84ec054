// A map cell as it is kept from frame to frame, and the hits of one frame (spec 1 §3).
const UNKNOWN = 0u;
const FREE = 1u;
const OCCUPIED = 2u;

// Both are stored as vec4<u32>, which loads and stores in one go.
struct Cell {
    occupancy: f32,     // p
    state: u32,         // UNKNOWN, FREE or OCCUPIED in bits 0-1; consecutive hits in bits 8-15
    history: u32,       // one bit per observed frame, the newest lowest: 1 = hit
    top: u32,           // highest hit recorded, in steps above height_min; 0 = none
}

struct CellHits {
    count: u32,         // pixels that ended in the cell inside the height band
    weight: u32,        // sum of their weights, fixed point
    top: u32,           // highest of them, in steps above height_min
    floor: u32,         // 1 where a trusted floor point lies in the cell
}

fn to_cell(v: vec4<u32>) -> Cell {
    return Cell(bitcast<f32>(v.x), v.y, v.z, v.w);
}

fn from_cell(cell: Cell) -> vec4<u32> {
    return vec4(bitcast<u32>(cell.occupancy), cell.state, cell.history, cell.top);
}

fn to_hits(v: vec4<u32>) -> CellHits {
    return CellHits(v.x, v.y, v.z, v.w);
}

// Fixed-point scale of heights: 1/65536 m, 0 is kept for "none".
const HEIGHT_STEPS_PER_M = 65536.0;

fn height_to_steps(height_above_min_m: f32) -> u32 {
    return u32(clamp(height_above_min_m * HEIGHT_STEPS_PER_M, 0.0, 4.0e9)) + 1u;
}

fn steps_to_height(steps: u32) -> f32 {
    return f32(steps - 1u) / HEIGHT_STEPS_PER_M;
}

// Where window cell (x, y) lies in the ring buffer of kept cells.
fn slot_of(x: u32, y: u32, origin_slot_x: u32, origin_slot_y: u32, side: u32) -> u32 {
    return ((y + origin_slot_y) % side) * side + (x + origin_slot_x) % side;
}
