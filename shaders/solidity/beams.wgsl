// Of each cell with returns: the beams that ended before it and those that went on behind it, within the heights of its returns.
// spec 6 §3 (permeability). Beams are known by bins of direction: how many, the nearest end, the farthest; between these two
// they are taken to end evenly.
@group(0) @binding(0) var<uniform> solidity_params: SolidityParams;
@group(0) @binding(1) var<storage, read> cell_counts: array<u32>;
@group(0) @binding(2) var<storage, read> beam_bins: array<u32>;
// Beams before and behind; beams that the sensor sends there if it sends as many to all sides.
@group(0) @binding(3) var<storage, read_write> cell_beams: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read> ground_now: array<vec4<f32>>;
// As in solidity/judge, for the cells in which nothing stands.
@group(0) @binding(5) var<storage, read_write> passable_cells: array<u32>;
@group(0) @binding(6) var<storage, read_write> solidity_inputs: array<f32>;
// How many cells have something that stands, and these, in any order: solidity/judge goes through them alone.
@group(0) @binding(7) var<storage, read_write> standing_cells: array<atomic<u32>>;

// Whether the inputs are kept for the host.
override keep_inputs: bool = false;

// Most sectors of a cell that are looked at, from its middle.
const MOST_SECTORS = 24u;
// Inputs of a cell, of which the first is 0 where nothing stands.
const INPUTS = 48u;
// What a ring may be thick, metres above and below the returns.
const RING_M = 0.05;

fn ground_known() -> bool {
    return ground_now[1].x > 0.5 || solidity_params.ground_stated == 1u;
}

// Where on the ring of sectors a direction lies (sector_of without rounding).
fn turn_of(at: vec2<f32>) -> f32 {
    let length = abs(at.x) + abs(at.y);
    let share = select(abs(at.y) / length, 0.0, length == 0.0);
    var turn = select(share, 2.0 - share, at.x < 0.0);
    turn = select(turn, 4.0 - turn, at.y < 0.0);
    return turn * f32(SECTORS) / 4.0;
}

// Sectors that a cell covers: the first, how many, and how much of them.
struct Sectors {
    first: u32,
    count: u32,
    share: f32,
}

fn sectors_of(centre: vec2<f32>, range_m: f32) -> Sectors {
    let aside = 0.5 * solidity_params.resolution_m / range_m * vec2(-centre.y, centre.x);
    let ends = vec2(turn_of(centre - aside), turn_of(centre + aside));
    let wide = ends.y - ends.x + select(0.0, f32(SECTORS), ends.y < ends.x);
    let whole = u32(fract(ends.x) + wide) + 1u;
    let kept = min(whole, MOST_SECTORS);
    return Sectors((u32(ends.x) + (whole - kept) / 2u) % SECTORS, kept, wide / f32(kept));
}

fn bin_of(height_m: f32, range_m: f32) -> u32 {
    return u32(clamp(bin_of_slope(height_m / range_m), 0.0, f32(SLOPE_BINS) - 0.001));
}

// Of a bin, beams that end before `near` and behind `far`.
fn parted(bin: u32, near: f32, far: f32) -> vec2<f32> {
    let beams = f32(beam_bins[bin + 2u]);
    let last = f32(beam_bins[bin]);
    let first = f32(MOST_BEAM_STEPS + 1u - beam_bins[bin + 1u]);
    let between = max(beams - 2.0, 0.0) / max(last - first, 1.0);
    let behind = select(1.0 + between * (last - far), beams, first >= far);
    let before = select(1.0 + between * (near - first), beams, last <= near);
    return vec2(select(before, 0.0, first >= near), select(behind, 0.0, last < far));
}

// Enters a cell where something stands; else what returns there are, are the floor's.
fn list(cell: u32) {
    if cell_counts[CELL_COUNTS * cell + 5u] > 0u {
        let place = 1u + atomicAdd(&standing_cells[0], 1u);
        atomicStore(&standing_cells[place], cell);
        return;
    }
    passable_cells[cell] = select(0u, 1u, ground_known() && cell_counts[CELL_COUNTS * cell + 12u] == 0u);
    if keep_inputs {
        solidity_inputs[INPUTS * cell] = 0.0;
    }
}

@compute @workgroup_size(8, 8)
fn beams(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = solidity_params.side;
    if id.x >= side || id.y >= side {
        return;
    }
    let cell = id.y * side + id.x;
    list(cell);
    let highest = cell_counts[CELL_COUNTS * cell + 5u];
    let centre = (vec2(f32(id.x), f32(id.y)) + 0.5) * solidity_params.resolution_m - solidity_params.lidar;
    let range_m = length(centre);
    if highest == 0u || range_m < solidity_params.resolution_m {
        cell_beams[cell] = vec4(0.0);
        return;
    }
    let lidar_m = dot(ground_now[0].xy, solidity_params.lidar) + ground_now[0].w;
    let lowest = ROOF_STEPS - cell_counts[CELL_COUNTS * cell + 4u];
    let low = bin_of(f32(lowest) / HEIGHT_STEPS_PER_M - lidar_m - RING_M, range_m);
    let high = bin_of(f32(highest - 1u) / HEIGHT_STEPS_PER_M - lidar_m + RING_M, range_m);
    let near = (range_m - 0.5 * solidity_params.resolution_m) * SECTOR_STEPS_PER_M;
    let far = (range_m + 0.5 * solidity_params.resolution_m) * SECTOR_STEPS_PER_M;
    let sectors = sectors_of(centre, range_m);
    var sums = vec4(0.0);
    for (var slope = low; slope < min(high + 1u, SLOPE_BINS); slope++) {
        sums.z += f32(beam_bins[BIN_WORDS * SECTORS * SLOPE_BINS + slope]) / f32(SECTORS) * f32(sectors.count);
        for (var i = 0u; i < min(sectors.count, MOST_SECTORS); i++) {
            let bin = BIN_WORDS * ((sectors.first + i) % SECTORS * SLOPE_BINS + slope);
            if beam_bins[bin + 2u] > 0u {
                sums += vec4(parted(bin, near, far), 0.0, 0.0);
            }
        }
    }
    cell_beams[cell] = sums * sectors.share;
}
