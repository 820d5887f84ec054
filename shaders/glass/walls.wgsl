// Finds walls: upright planes on which more returns of a few level rows lie than behind them, the one with the most first. A mirror
// hangs on one, and returns little of its own (spec 6 §1, §4). And empties what is counted behind them.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(2) var<storage, read> beam_cells: array<u32>;
@group(0) @binding(3) var<storage, read> found: Found;
@group(0) @binding(4) var<storage, read> scan_panes: array<Pane>;
@group(0) @binding(5) var<storage, read_write> scan_walls: Walls;
@group(0) @binding(6) var<storage, read_write> wall_strips: array<u32>;
@group(0) @binding(7) var<storage, read_write> passed_beams: array<u32>;

const LANES = 64u;
// Returns that are looked at: of every second row from the level one upwards, at even steps of azimuth; so many by each lane.
const ROW_STEP = 2u;
const EACH_ROW = 128u;
const SAMPLES = 512u;
const EACH = 8u;
// Far from everything, metres: a return that is missing, or taken by a wall.
const NOWHERE_M = 1e6;
// A hypothesis a lane: a line through two returns of a row, this far apart.
const LEAST_LEG_M = 0.3;
const MOST_LEG_M = 1.5;
const MOST_STEPS = 12u;
const TRIES = 4u;
const REFITS = 2u;
// Returns that make a wall.
const LEAST_ON = 20u;
// Nearer than this to the sensor a plane is no wall, metres.
const LEAST_AWAY_M = 0.3;
// A pane is in a wall when their normals are within 8 degrees and its middle is this near to the wall, metres; no mirror is looked for
// there, nor this far beside it.
const SAME_COS = 0.99;
const SAME_M = 0.3;
const BESIDE_M = 0.3;

var<workgroup> samples: array<vec2<f32>, SAMPLES>;
var<workgroup> lines: array<vec3<f32>, LANES>;      // n, d
var<workgroup> votes: array<atomic<u32>, LANES>;
var<workgroup> firsts: array<vec3<f32>, LANES>;     // sums of x, y; count
var<workgroup> squares: array<vec3<f32>, LANES>;    // xx, yy, xy
var<workgroup> line: vec3<f32>;
var<workgroup> taken: u32;
var<workgroup> behind: atomic<u32>;

// Axes of the level plane, in the lidar's frame.
fn level_axes() -> mat2x3<f32> {
    let up = normalize(glass_params.local_from_lidar_z.xyz);
    let along = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), abs(up.x) > 0.7);
    let first = normalize(cross(up, along));
    return mat2x3<f32>(first, cross(up, first));
}

fn sample(number: u32, axes: mat2x3<f32>) -> vec2<f32> {
    let row = glass_params.level_row + ROW_STEP * (number / EACH_ROW);
    let column = (number % EACH_ROW) * glass_params.columns / EACH_ROW;
    if row >= glass_params.rows {
        return vec2(NOWHERE_M);
    }
    let word = beam_cells[2u * (column * glass_params.rows + row)];
    if word == NONE {
        return vec2(NOWHERE_M);
    }
    return point_at(index_in(word)).xyz * axes;
}

fn is_taken(at: vec2<f32>) -> bool {
    return at.x > 0.5 * NOWHERE_M;
}

// The line of hypothesis `number`, n and d > 0; d = 0 where the draw makes none.
fn drawn(number: u32) -> vec3<f32> {
    var word = hash(glass_params.seed ^ hash(number));
    for (var k = 0u; k < TRIES; k++) {
        word = select(word, hash(word), is_taken(samples[word % SAMPLES]));
    }
    let a = word % SAMPLES;
    let b = a - a % EACH_ROW + (a + 1u + hash(word ^ 0x9e3779b9u) % MOST_STEPS) % EACH_ROW;
    let leg = samples[b] - samples[a];
    let far = length(leg);
    if is_taken(samples[a]) || far < LEAST_LEG_M || far > MOST_LEG_M {
        return vec3(0.0);
    }
    let n = vec2(-leg.y, leg.x) / far;
    let d = dot(n, samples[a]);
    return select(vec3(-n, -d), vec3(n, d), d > 0.0);
}

fn is_near(wall_line: vec3<f32>, at: vec2<f32>) -> bool {
    return wall_line.z > 0.0 && abs(dot(wall_line.xy, at) - wall_line.z) < glass_params.fit_tolerance_m;
}

// Counts the returns of this lane near each hypothesis.
fn vote(lane: u32) {
    var own: array<vec2<f32>, EACH>;
    for (var k = 0u; k < EACH; k++) {
        own[k] = samples[lane + k * LANES];
    }
    for (var h = 0u; h < LANES; h++) {
        // No two lanes at the same one.
        let number = (h + lane) % LANES;
        let here = lines[number];
        var near = 0u;
        for (var k = 0u; k < EACH; k++) {
            near += select(0u, 1u, is_near(here, own[k]));
        }
        if near > 0u && here.z > LEAST_AWAY_M {
            atomicAdd(&votes[number], near);
        }
    }
}

fn best_of_all() -> vec3<f32> {
    var best = vec3(0.0);
    var most = 0u;
    for (var k = 0u; k < LANES; k++) {
        let near = atomicLoad(&votes[k]);
        best = select(best, lines[k], near > most);
        most = max(most, near);
    }
    return best;
}

fn sum_near(lane: u32) {
    let here = line;
    var first = vec3(0.0);
    var square = vec3(0.0);
    for (var k = lane; k < SAMPLES; k += LANES) {
        let at = samples[k];
        let near = is_near(here, at);
        // Sums about a point on the line keep their digits.
        let off = at - here.xy * here.z;
        first += select(vec3(0.0), vec3(off, 1.0), near);
        square += select(vec3(0.0), vec3(off.x * off.x, off.y * off.y, off.x * off.y), near);
    }
    firsts[lane] = first;
    squares[lane] = square;
}

// The least-squares line of the sums, and how many returns they are of.
fn fitted() -> vec4<f32> {
    var first = vec3(0.0);
    var square = vec3(0.0);
    for (var k = 0u; k < LANES; k++) {
        first += firsts[k];
        square += squares[k];
    }
    if first.z < 2.0 {
        return vec4(line, first.z);
    }
    let mean = first.xy / first.z;
    let spread = square / first.z - vec3(mean.x * mean.x, mean.y * mean.y, mean.x * mean.y);
    let along = 0.5 * atan2(2.0 * spread.z, spread.x - spread.y);
    let n = vec2(-sin(along), cos(along));
    let d = dot(n, mean + line.xy * line.z);
    return vec4(select(vec3(-n, -d), vec3(n, d), d > 0.0), first.z);
}

// Counts the returns behind the line, also those that another wall has taken, and takes those near it.
fn count_behind(lane: u32, axes: mat2x3<f32>) {
    for (var k = lane; k < SAMPLES; k += LANES) {
        let at = sample(k, axes);
        let along = dot(line.xy, at);
        if !is_taken(at) && along > line.z + BEHIND_M && along > GRAZING_COS * length(at) {
            atomicAdd(&behind, 1u);
        }
        samples[k] = select(samples[k], vec2(NOWHERE_M), is_near(line, samples[k]));
    }
}

// Where panes of this scan lie in a wall's plane: least and largest u.
fn glazed_part(wall: vec4<f32>) -> vec2<f32> {
    let level = level_axis(wall.xyz);
    var part = vec2(1e9, -1e9);
    for (var k = 0u; k < min(found.panes, SCAN_PANES); k++) {
        let pane = scan_panes[k];
        let e = pane.extent;
        let foot = pane.normal.xyz * pane.normal.w + cross(pane.normal.xyz, pane.level.xyz) * 0.5 * (e.z + e.w);
        let off = dot(wall.xyz, foot + pane.level.xyz * 0.5 * (e.x + e.y)) - wall.w;
        let u = vec2(dot(foot, level)) + dot(pane.level.xyz, level) * e.xy;
        let in_wall = dot(wall.xyz, pane.normal.xyz) > SAME_COS && abs(off) < SAME_M;
        part = select(part, vec2(min(part.x, min(u.x, u.y) - BESIDE_M), max(part.y, max(u.x, u.y) + BESIDE_M)), in_wall);
    }
    return part;
}

fn store(wall: u32, axes: mat2x3<f32>) {
    let is_wall = taken >= LEAST_ON && line.z > LEAST_AWAY_M && atomicLoad(&behind) <= taken;
    let plane = select(vec4(0.0), vec4(axes * line.xy, line.z), is_wall);
    scan_walls.planes[wall] = plane;
    scan_walls.levels[wall] = vec4(level_axis(plane.xyz), 0.0);
    scan_walls.glazed[wall] = vec4(glazed_part(plane), 0.0, 0.0);
}

fn begin(lane: u32, axes: mat2x3<f32>) {
    for (var k = lane; k < SAMPLES; k += LANES) {
        samples[k] = sample(k, axes);
    }
    for (var k = lane; k < WALLS * STRIPS * STRIP_WORDS; k += LANES) {
        wall_strips[k] = select(0u, NONE, k % STRIP_WORDS == LOWEST);
    }
    for (var once = 0u; once < turns_if(lane == 0u); once++) {
        passed_beams[PASSED_COUNT] = 0u;
    }
}

@compute @workgroup_size(LANES)
fn walls(@builtin(local_invocation_index) lane: u32) {
    let axes = level_axes();
    begin(lane, axes);
    workgroupBarrier();
    for (var wall = 0u; wall < WALLS; wall++) {
        lines[lane] = drawn(wall * LANES + lane);
        atomicStore(&votes[lane], 0u);
        workgroupBarrier();
        vote(lane);
        workgroupBarrier();
        for (var once = 0u; once < turns_if(lane == 0u); once++) {
            line = best_of_all();
            atomicStore(&behind, 0u);
        }
        workgroupBarrier();
        for (var turn = 0u; turn < REFITS; turn++) {
            sum_near(lane);
            workgroupBarrier();
            for (var once = 0u; once < turns_if(lane == 0u); once++) {
                let fit = fitted();
                line = fit.xyz;
                taken = u32(fit.w);
            }
            workgroupBarrier();
        }
        count_behind(lane, axes);
        workgroupBarrier();
        for (var once = 0u; once < turns_if(lane == 0u); once++) {
            store(wall, axes);
        }
        workgroupBarrier();
    }
}
