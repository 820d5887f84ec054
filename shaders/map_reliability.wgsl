// Judges which cells are obstacles by what was seen of them and around them: a small network a cell (map reliability).
// spec 1 §9; weights/README.md lists the inputs. Runs after `update` by evidence, over the cells that the frame looked at. Needs
// lib/cell, lib/evidence, lib/fusion/strength, lib/record, lib/slot, lib/weight.
struct MapReliabilityParams {
    side: u32,
    origin_slot_x: u32,
    origin_slot_y: u32,
    tick: u32,
    weight_scale: f32,          // fixed-point one of weights
    release: f32,               // how far under 0 the network must come before an obstacle is given up
    pad_x: u32,
    pad_y: u32,
}

// Whether looks count by time, as in `update`.
override timed: bool = false;
// Whether the inputs are kept for the host.
override keep_inputs: bool = false;

@group(0) @binding(0) var<uniform> map_reliability_params: MapReliabilityParams;
@group(0) @binding(1) var<storage, read> cell_hits: array<CellHits>;
@group(0) @binding(2) var<storage, read> seen_through: array<u32>;
// Four words a cell, as to_cell takes them: only the word with the state is written, and only evidence is read of other cells.
@group(0) @binding(3) var<storage, read_write> cells: array<u32>;
@group(0) @binding(4) var<storage, read> cell_marks: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read_write> cell_looks: array<array<vec4<f32>, 2>>;
@group(0) @binding(6) var<storage, read_write> state: array<u32>;
// Of each hidden unit a weight for each input and what is added; the units' weights; what is added.
@group(0) @binding(7) var<storage, read> map_reliability_weights: array<f32>;
@group(0) @binding(8) var<storage, read_write> map_reliability_inputs: array<f32>;
@group(0) @binding(9) var<uniform> evidence_params: EvidenceParams;

const INPUTS = 22u;
const HIDDEN = 16u;

// What is left of a cell's looks after another.
const KEPT_LOOKS = 0.9;
// Evidence for a cell, and looks with hits, under which it is none of the obstacles: what was seen once is none. And the evidence from
// which it is a strong one.
const LEAST_FOR = 0.22;
const LEAST_HITS = 1.5;
const STRONG_FOR = 1.75;
// With so much evidence against it, and less than RELEASED_BY times that for it, a cell that is no obstacle is free.
const LEAST_AGAINST = 0.002;
const RELEASED_BY = 1.75;

const WORDS = 4u;
const FOR_WORD = 0u;
const STATE_WORD = 1u;
const AGAINST_WORD = 2u;
const TOP_WORD = 3u;

// Cells around that count: to each side, how many that are; and along the ray, behind and before.
const NEAR = 1;
const WIDE = 3;
const ACROSS = 7;
const NEARS = 8.0;
const WIDES = 48.0;
const ALONG = 4;
// Higher above the height band's lower edge is as high.
const MOST_HEIGHT_M = 2.0;

// Sums over a cell's looks, each worth KEPT_LOOKS of the next.
struct Looks {
    hit: f32,           // those with hits
    through: f32,       // shares of pixels that looked through
    strength: f32,      // evidence for
    reliability: f32,   // mean R of the hits
    floor: f32,         // those with a floor point alone
    all: f32,
    last_tick: u32,
    obstacle: bool,     // what the network said
}

fn to_looks(words: array<vec4<f32>, 2>) -> Looks {
    let last = words[1];
    return Looks(words[0].x, words[0].y, words[0].z, words[0].w, last.x, last.y, bitcast<u32>(last.z), last.w > 0.0);
}

fn from_looks(looks: Looks) -> array<vec4<f32>, 2> {
    let last = vec4(looks.floor, looks.all, bitcast<f32>(looks.last_tick), select(0.0, 1.0, looks.obstacle));
    return array(vec4(looks.hit, looks.through, looks.strength, looks.reliability), last);
}

fn slot_at(x: i32, y: i32) -> u32 {
    let params = map_reliability_params;
    return slot_of(u32(x), u32(y), params.origin_slot_x, params.origin_slot_y, params.side);
}

// Evidence for and against a cell of the window, 0 outside.
fn evidence_at(x: i32, y: i32) -> vec2<f32> {
    let side = i32(map_reliability_params.side);
    if x < 0 || y < 0 || x >= side || y >= side {
        return vec2(0.0);
    }
    let word = WORDS * slot_at(x, y);
    return vec2(bitcast<f32>(cells[word + FOR_WORD]), bitcast<f32>(cells[word + AGAINST_WORD]));
}

// From the camera to the middle of a cell of the window.
fn offset_of(x: i32, y: i32) -> vec2<f32> {
    return (vec2(f32(x), f32(y)) + 0.5) * evidence_params.resolution_m - evidence_params.camera_xy_m;
}

// The looks at a cell with the frame's: `i` in the window, `distance_m` from the camera.
fn with_look(looks: Looks, i: u32, distance_m: f32) -> Looks {
    let hits = cell_hits[i];
    let hit = (state[i] & WAS_HIT) != 0u;
    let since = map_reliability_params.tick - min(looks.last_tick, map_reliability_params.tick);
    let by_time = timed && looks.all > 0.0;
    let share = select(1.0, min(1.0, f32(since) * evidence_params.looks_per_tick), by_time);
    let left = select(KEPT_LOOKS, pow(KEPT_LOOKS, share), by_time);
    let added = (1.0 - left) / (1.0 - KEPT_LOOKS);
    let hit_added = select(0.0, added, hit);
    let count = max(f32(hits.count), 1.0);
    let trust = select(count, f32(hits.weight) / map_reliability_params.weight_scale, weighted);
    let through = f32(seen_through[i] & SHARE_ONE) / f32(SHARE_ONE);
    return Looks(
        left * looks.hit + hit_added,
        left * looks.through + added * through,
        left * looks.strength + hit_added * strength_of_hits(evidence_params, count, trust, distance_m),
        left * looks.reliability + hit_added * trust / count,
        left * looks.floor + select(0.0, added, !hit && hits.top == FLOOR),
        left * looks.all + added,
        map_reliability_params.tick,
        looks.obstacle,
    );
}

// Evidence around a cell: sums for and against of the others within a distance, how many are strong, the most for one.
struct Around {
    evidence: vec2<f32>,
    strong: f32,
    most: f32,
}

fn with_cell(around: Around, evidence: vec2<f32>) -> Around {
    let strong = around.strong + select(0.0, 1.0, evidence.x >= STRONG_FOR);
    return Around(around.evidence + evidence, strong, max(around.most, evidence.x));
}

fn log_for(evidence: f32) -> f32 {
    return log2(evidence + 0.05);
}

fn log_against(evidence: f32) -> f32 {
    return log2(evidence + 0.02);
}

// What surrounds a cell, but for itself, within NEAR and within WIDE cells to each side.
fn around(x: i32, y: i32) -> array<Around, 2> {
    var near = Around(vec2(0.0), 0.0, 0.0);
    var wide = near;
    for (var k = 0; k < ACROSS * ACROSS; k++) {
        let dx = k % ACROSS - WIDE;
        let dy = k / ACROSS - WIDE;
        let evidence = evidence_at(x + dx, y + dy);
        let far = max(abs(dx), abs(dy));
        if far > 0 {
            wide = with_cell(wide, evidence);
        }
        if far > 0 && far <= NEAR {
            near = with_cell(near, evidence);
        }
    }
    return array(near, wide);
}

// Most evidence along the ray through a cell: for at one or two cells behind it, at three or four; for before it; against behind it.
fn along(x: i32, y: i32, ray: vec2<f32>) -> vec4<f32> {
    let middle = vec2(f32(x), f32(y)) + 0.5;
    var most = vec4(0.0);
    for (var k = 1; k < ALONG + 1; k++) {
        let there = vec2<i32>(floor(middle + ray * f32(k)));
        let here = vec2<i32>(floor(middle - ray * f32(k)));
        let behind = evidence_at(there.x, there.y);
        let before = evidence_at(here.x, here.y);
        let near = 2 * k <= ALONG;
        most = max(most, vec4(select(0.0, behind.x, near), select(behind.x, 0.0, near), before.x, behind.y));
    }
    return most;
}

fn inputs_of(x: i32, y: i32, slot: u32, looks: Looks) -> array<f32, INPUTS> {
    let both = around(x, y);
    let near = both[0];
    let wide = both[1];
    let offset = offset_of(x, y);
    let distance_m = max(length(offset), NEAREST_M);
    let ray = along(x, y, offset / distance_m);
    let own = evidence_at(x, y);
    let all = max(looks.all, 1.0e-3);
    let high_m = steps_to_height(max(cells[WORDS * slot + TOP_WORD], FLOOR + 1u));
    let low_m = f32(cell_marks[slot].y & 0xffffu) / RECORD_STEPS_PER_M;
    return array<f32, INPUTS>(
        looks.hit / all, looks.through / all, looks.strength / all, looks.reliability / all,
        looks.floor / all, log_for(own.x), log_against(own.y), log2(all),
        distance_m, min(low_m, MOST_HEIGHT_M), min(high_m, MOST_HEIGHT_M), log_for(near.evidence.x / NEARS),
        log_against(near.evidence.y / NEARS), near.strong / NEARS, log_for(near.most), log_for(wide.evidence.x / WIDES),
        log_against(wide.evidence.y / WIDES), wide.strong / WIDES, log_for(ray.x), log_for(ray.y),
        log_for(ray.z), log_against(ray.w),
    );
}

// Above 0 is an obstacle.
fn logit(inputs: ptr<function, array<f32, INPUTS>>) -> f32 {
    let outer = HIDDEN * (INPUTS + 1u);
    var sum = map_reliability_weights[outer + HIDDEN];
    for (var unit = 0u; unit < HIDDEN; unit++) {
        let first = unit * (INPUTS + 1u);
        var inner = map_reliability_weights[first + INPUTS];
        for (var k = 0u; k < INPUTS; k++) {
            inner += map_reliability_weights[first + k] * (*inputs)[k];
        }
        sum += map_reliability_weights[outer + unit] * tanh(clamp(inner, -15.0, 15.0));
    }
    return sum;
}

// Whether the network calls a cell an obstacle; one that it called so stays one until it is more than a little under 0.
fn is_obstacle(x: i32, y: i32, slot: u32, i: u32, looks: Looks) -> bool {
    if evidence_at(x, y).x < LEAST_FOR {
        return false;
    }
    var inputs = inputs_of(x, y, slot, looks);
    if keep_inputs {
        for (var k = 0u; k < INPUTS; k++) {
            map_reliability_inputs[INPUTS * i + k] = inputs[k];
        }
    }
    let least = select(0.0, -map_reliability_params.release, looks.obstacle);
    return looks.hit >= LEAST_HITS && logit(&inputs) >= least;
}

@compute @workgroup_size(16, 4)
fn map_reliability(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = map_reliability_params.side;
    if id.x >= side || id.y >= side {
        return;
    }
    let i = id.y * side + id.x;
    if keep_inputs {
        for (var k = 0u; k < INPUTS; k++) {
            map_reliability_inputs[INPUTS * i + k] = 0.0;
        }
    }
    if (state[i] & (WAS_HIT | WAS_SEEN_THROUGH)) == 0u {
        return;
    }
    let x = i32(id.x);
    let y = i32(id.y);
    let slot = slot_at(x, y);
    var looks = with_look(to_looks(cell_looks[slot]), i, length(offset_of(x, y)));
    looks.obstacle = is_obstacle(x, y, slot, i, looks);
    cell_looks[slot] = from_looks(looks);
    let own = evidence_at(x, y);
    let free = own.y >= LEAST_AGAINST && own.x < RELEASED_BY * own.y;
    let now = select(select(UNKNOWN, FREE, free), OCCUPIED, looks.obstacle);
    let word = cells[WORDS * slot + STATE_WORD];
    cells[WORDS * slot + STATE_WORD] = (word & ~3u) | now;
    state[i] = (state[i] & ~3u) | now;
}
