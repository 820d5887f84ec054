// Whether a robot can pass what stands in a cell: a small model of its counts and of those around it.
// spec 6 §3; weights/README.md lists the inputs. A cell with too little evidence is solid, and so is all where the ground is not known.
@group(0) @binding(0) var<uniform> solidity_params: SolidityParams;
@group(0) @binding(1) var<storage, read> cell_counts: array<u32>;
@group(0) @binding(2) var<storage, read> cell_beams: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> ground_now: array<vec4<f32>>;
// Of each hidden unit a weight for each input and what is added; the units' weights; what is added without intensities, and with.
@group(0) @binding(4) var<storage, read> solidity_weights: array<f32>;
// 1: the robot can pass what stands there.
@group(0) @binding(5) var<storage, read_write> passable_cells: array<u32>;
@group(0) @binding(6) var<storage, read_write> solidity_inputs: array<f32>;
// How many cells have something that stands, and these.
@group(0) @binding(7) var<storage, read> standing_cells: array<u32>;

// Whether the inputs are kept for the host.
override keep_inputs: bool = false;

const INPUTS = 48u;
const HIDDEN = 8u;
// Cells to each side that are looked at, at most.
const MOST_REACH = 6u;
// Which input says whether there are intensities.
const CONTRAST_KNOWN = 26u;
// Those of sheets: share of beams that go on, least spread in decimetres, span of heights in metres.
const WENT_ON = 5u;
const LEAST_SPREAD = 13u;
const SPAN = 18u;

// What is known of a cell, or of one and those around it; contrasts from CONTRAST_ZERO under the trend.
struct Counts {
    bands: vec4<f32>,
    lowest_m: f32,
    highest_m: f32,
    paired: f32,
    lit: f32,
    contrast: f32,
    contrast_square: f32,
    beams: vec4<f32>,
    cells: f32,
    // Of the middles of the cells' returns: weight, first and second moments in cells from the centre, x, y and xy.
    first: vec2<f32>,
    second: vec3<f32>,
    // Variance along the beam within the cells, times returns, cells squared.
    within: f32,
}

fn returns_of(counts: Counts) -> f32 {
    return counts.bands.x + counts.bands.y + counts.bands.z + counts.bands.w;
}

fn word_of(cell: u32, word: u32) -> f32 {
    return f32(cell_counts[CELL_COUNTS * cell + word]);
}

// Of a cell at that offset of cells from the one that is judged; along: the beam's direction there.
fn counts_of(cell: u32, offset: vec2<f32>, along: vec2<f32>) -> Counts {
    let bands = vec4(word_of(cell, 0u), word_of(cell, 1u), word_of(cell, 2u), word_of(cell, 3u));
    let returns = max(bands.x + bands.y + bands.z + bands.w, 1.0);
    let depth = vec2(word_of(cell, 6u), word_of(cell, 7u)) / (returns * vec2(DEPTH_STEPS, DEPTH_STEPS * DEPTH_STEPS));
    let middle = offset + along * (depth.x - DEPTH_ZERO);
    let lit = word_of(cell, 9u);
    return Counts(
        bands,
        (f32(ROOF_STEPS) - word_of(cell, 4u)) / HEIGHT_STEPS_PER_M,
        (word_of(cell, 5u) - 1.0) / HEIGHT_STEPS_PER_M,
        word_of(cell, 8u),
        lit,
        word_of(cell, 10u) / CONTRAST_STEPS,
        word_of(cell, 11u) / (CONTRAST_STEPS * CONTRAST_STEPS),
        cell_beams[cell],
        1.0,
        returns * middle,
        returns * vec3(middle * middle, middle.x * middle.y),
        returns * max(depth.y - depth.x * depth.x, 0.0),
    );
}

fn joined(a: Counts, b: Counts) -> Counts {
    return Counts(
        a.bands + b.bands,
        min(a.lowest_m, b.lowest_m),
        max(a.highest_m, b.highest_m),
        a.paired + b.paired,
        a.lit + b.lit,
        a.contrast + b.contrast,
        a.contrast_square + b.contrast_square,
        a.beams + b.beams,
        a.cells + b.cells,
        a.first + b.first,
        a.second + b.second,
        a.within + b.within,
    );
}

// Deviation of the returns across the beam's direction and along it, and the lesser and the larger of all directions, cells.
fn spreads(counts: Counts, along: vec2<f32>) -> vec4<f32> {
    let returns = max(returns_of(counts), 1.0);
    let mean = counts.first / returns;
    let xx = max(counts.second.x / returns - mean.x * mean.x, 0.0);
    let yy = max(counts.second.y / returns - mean.y * mean.y, 0.0);
    let xy = counts.second.z / returns - mean.x * mean.y;
    let within = counts.within / returns;
    let beam = along.x * along.x * xx + along.y * along.y * yy + 2.0 * along.x * along.y * xy;
    let across = xx + yy - beam;
    let half = 0.5 * (xx + yy);
    let apart = sqrt(max(half * half - xx * yy + xy * xy, 0.0));
    return sqrt(max(vec4(across, beam + within, half - apart + within, half + apart), vec4(0.0)));
}

// Shares of beams: that went on of those that entered, that ended of those sent there, hidden, lost.
fn shares(counts: Counts) -> vec4<f32> {
    let ended = returns_of(counts);
    let before = counts.beams.x;
    let behind = counts.beams.y;
    let all = before + behind + ended + 0.5;
    let lost = max(counts.beams.z + 0.5 - all, 0.0) / (counts.beams.z + 0.5);
    return vec4(behind / (behind + ended + 0.5), ended / all, before / all, lost);
}

fn around(id: vec2<u32>, along: vec2<f32>) -> Counts {
    let side = solidity_params.side;
    let reach = min(solidity_params.reach_cells, MOST_REACH);
    var sum = counts_of(id.y * side + id.x, vec2(0.0), along);
    let first = id - min(id, vec2(reach));
    let last = min(id + vec2(reach), vec2(side - 1u));
    for (var y = first.y; y < min(last.y + 1u, side); y++) {
        for (var x = first.x; x < min(last.x + 1u, side); x++) {
            let cell = y * side + x;
            if cell_counts[CELL_COUNTS * cell + 5u] > 0u && any(vec2(x, y) != id) {
                sum = joined(sum, counts_of(cell, vec2(f32(x) - f32(id.x), f32(y) - f32(id.y)), along));
            }
        }
    }
    return sum;
}

// Returns by height in the block of a cell and the eight around it.
struct Wide {
    bands: vec4<f32>,
    highest_m: f32,
    blocks: f32,
}

fn wide_of(id: vec2<u32>) -> Wide {
    let size = solidity_params.block_cells;
    var wide = Wide(vec4(0.0), 0.0, 0.0);
    for (var i = 0u; i < 9u; i++) {
        // From one cell before the window on, so that no number is below 0.
        let at = id + vec2(i % 3u, i / 3u) * size;
        if any(at < vec2(size)) || any(at - vec2(size) >= vec2(solidity_params.side)) {
            continue;
        }
        let word = block_word(at - vec2(size));
        let highest = cell_counts[word + 4u];
        if highest > 0u {
            let bands = vec4(cell_counts[word], cell_counts[word + 1u], cell_counts[word + 2u], cell_counts[word + 3u]);
            wide.bands += vec4<f32>(bands);
            wide.highest_m = max(wide.highest_m, f32(highest - 1u) / HEIGHT_STEPS_PER_M);
            wide.blocks += 1.0;
        }
    }
    return wide;
}

// Mean and deviation of the contrast.
fn light_of(all: Counts) -> vec2<f32> {
    let lit = max(all.lit, 1.0);
    let mean = all.contrast / lit;
    let known = select(0.0, 1.0, all.lit > 0.0);
    return known * vec2(mean - CONTRAST_ZERO, sqrt(max(all.contrast_square / lit - mean * mean, 0.0)));
}

fn inputs_of(own: Counts, all: Counts, wide: Wide, range_m: f32, along: vec2<f32>) -> array<f32, INPUTS> {
    let alone = shares(own);
    let near = shares(all);
    let spread = spreads(all, along) * (solidity_params.resolution_m / 0.1);
    let own_depth = sqrt(own.within / max(returns_of(own), 1.0));
    let many = log2(1.0 + returns_of(all));
    let away = log2(max(range_m, 0.5) / 5.0);
    let bands = all.bands / max(returns_of(all), 1.0);
    let known = select(0.0, 1.0, all.lit > 0.0);
    let light = light_of(all);
    let span_m = all.highest_m - all.lowest_m;
    let filled = 0.25 * dot(select(vec4(0.0), vec4(1.0), all.bands > vec4(0.0)), vec4(1.0));
    let wide_returns = dot(wide.bands, vec4(1.0));
    let wide_bands = wide.bands / max(wide_returns, 1.0);
    let across = f32(2u * solidity_params.reach_cells + 1u);
    return array<f32, INPUTS>(
        log2(1.0 + returns_of(own)), many, all.cells / (across * across), away,
        alone.x, near.x, alone.y, near.y,
        near.z, near.w, own_depth, spread.y,
        spread.x, spread.z, spread.w, own.lowest_m,
        own.highest_m, all.highest_m, span_m, own.highest_m - own.lowest_m,
        bands.x, bands.y, bands.z, filled,
        all.paired / max(returns_of(all), 1.0), solidity_params.two_returns, known, light.x,
        light.y, log2(solidity_params.resolution_m / 0.1), log2(1.0 + all.beams.z), wide.highest_m,
        wide_bands.x, wide_bands.y, wide_bands.z, log2(1.0 + wide_returns),
        wide.blocks / 9.0, near.x * all.highest_m, near.x * spread.z, near.x * many,
        spread.z * all.highest_m, spread.z * many, all.highest_m * all.highest_m, wide.highest_m * wide.highest_m,
        away * near.x, away * light.y, span_m * span_m, filled * spread.z,
    );
}

// A thin, upright sheet that few beams pass is solid whatever the model says: a wall in a pattern that no sensor of its training has.
fn is_sheet(inputs: ptr<function, array<f32, INPUTS>>) -> bool {
    return (*inputs)[LEAST_SPREAD] < 0.3 && (*inputs)[SPAN] > 0.5 && (*inputs)[WENT_ON] < 0.6;
}

// Above 0 is solid.
fn logit(inputs: ptr<function, array<f32, INPUTS>>) -> f32 {
    let outer = HIDDEN * (INPUTS + 1u);
    let known = (*inputs)[CONTRAST_KNOWN] > 0.5;
    var sum = select(solidity_weights[outer + HIDDEN], solidity_weights[outer + HIDDEN + 1u], known);
    for (var unit = 0u; unit < HIDDEN; unit++) {
        let first = unit * (INPUTS + 1u);
        var inner = solidity_weights[first + INPUTS];
        for (var i = 0u; i < INPUTS; i++) {
            inner += solidity_weights[first + i] * (*inputs)[i];
        }
        sum += solidity_weights[outer + unit] * tanh(clamp(inner, -15.0, 15.0));
    }
    return sum;
}

@compute @workgroup_size(64)
fn judge(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) within: u32,
) {
    let number = (group.y * groups.x + group.x) * 64u + within;
    if number >= standing_cells[0] {
        return;
    }
    let cell = standing_cells[1u + number];
    let side = solidity_params.side;
    let id = vec2(cell % side, cell / side);
    let ground = ground_now[1].x > 0.5 || solidity_params.ground_stated == 1u;
    let judged = ground && solidity_params.judged == 1u;
    let centre = (vec2(f32(id.x), f32(id.y)) + 0.5) * solidity_params.resolution_m - solidity_params.lidar;
    let range_m = length(centre);
    let along = centre / max(range_m, 1.0e-3);
    let own = counts_of(cell, vec2(0.0), along);
    let all = around(id, along);
    var inputs = inputs_of(own, all, wide_of(id), range_m, along);
    if keep_inputs {
        for (var i = 0u; i < INPUTS; i++) {
            solidity_inputs[INPUTS * cell + i] = inputs[i];
        }
    }
    let passable = judged && !is_sheet(&inputs) && logit(&inputs) < 0.0 && returns_of(all) >= f32(solidity_params.least_returns)
        && range_m >= solidity_params.resolution_m;
    passable_cells[cell] = select(0u, 1u, passable);
}
