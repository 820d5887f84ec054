// The organized cloud of a scan: rows by elevation (the lowest first) x columns by azimuth x two returns (spec 3 §1).
struct GlassParams {
    local_from_lidar_x: vec4<f32>,
    local_from_lidar_y: vec4<f32>,
    local_from_lidar_z: vec4<f32>,
    points: u32,
    rows: u32,
    columns: u32,
    rings: u32,
    level_row: u32,
    half_rows: u32,
    half_columns: u32,
    hypotheses: u32,
    seed: u32,
    remembers: u32,
    loaded: u32,
    min_inliers: u32,
    min_behind: u32,
    return_gap_m: f32,
    fit_tolerance_m: f32,
    plane_tolerance_m: f32,
    match_m: f32,
    match_per_m: f32,
    bright_ratio: f32,
    lobe_cos: f32,
    visible_cos: f32,
    replaces: u32,
    pad1: u32,
    pad2: u32,
}

const NONE = 0xffffffffu;
const PI = 3.14159265358979;

// A cell holds the nearest point that fell into it: its range in steps above, its number in the lowest 18 bits.
const INDEX_BITS = 18u;
const RANGE_STEPS_PER_M = 100.0;
const RANGE_STEPS_MOST = 16382.0;

// Elevations are looked up in bins over 180 degrees.
const ELEVATION_BINS = 2048.0;

// Slots of the sensor's returns (sensor::ReturnType).
const LAST = 2u;

fn slot_of_return(rest: vec4<u32>) -> u32 {
    return select(0u, 1u, (rest.z & 0xffu) == LAST);
}

fn ring_of(rest: vec4<u32>) -> u32 {
    return rest.y & 0xffffu;
}

fn index_in(word: u32) -> u32 {
    return word & ((1u << INDEX_BITS) - 1u);
}

fn steps_in(word: u32) -> u32 {
    return word >> INDEX_BITS;
}

fn cell_word(range_m: f32, index: u32) -> u32 {
    return (u32(clamp(range_m * RANGE_STEPS_PER_M, 0.0, RANGE_STEPS_MOST)) << INDEX_BITS) | index;
}

fn column_of(p: vec3<f32>, columns: u32) -> u32 {
    let turn = atan2(p.y, p.x) / (2.0 * PI) + 1.0;
    // At most one and a half times round; a remainder costs more than all else here.
    let column = u32(round(turn * f32(columns)));
    return select(column, column - columns, column >= columns);
}

// As column_of, of four.
fn columns_of(x: vec4<f32>, y: vec4<f32>, columns: u32) -> vec4<u32> {
    let turn = atan2(y, x) / (2.0 * PI) + 1.0;
    let column = vec4<u32>(round(turn * f32(columns)));
    return select(column, column - columns, column >= vec4(columns));
}

// As elevation_bin, of four at these heights and level distances.
fn elevation_bins(z: vec4<f32>, level: vec4<f32>) -> vec4<u32> {
    let share = atan2(z, level) / PI + 0.5;
    return vec4<u32>(clamp(share * ELEVATION_BINS, vec4(0.0), vec4(ELEVATION_BINS - 1.0)));
}

fn elevation_bin(p: vec3<f32>) -> u32 {
    let share = atan2(p.z, length(p.xy)) / PI + 0.5;
    return u32(clamp(share * ELEVATION_BINS, 0.0, ELEVATION_BINS - 1.0));
}

// How many of `count` things an invocation takes that begins at `first` and goes on by `stride`.
fn turns_from(first: u32, count: u32, stride: u32) -> u32 {
    return (max(count, first) - first + stride - 1u) / stride;
}

// Turns of a loop that stands for an `if`: drivers that run both sides of a branch under a mask leave a loop as soon as no
// lane needs it.
fn turns_if(condition: bool) -> u32 {
    return select(0u, 1u, condition);
}
