// Says of each cell that rays of a message met whether it is ground or a drop. spec 6 §2 (drop-offs).
// A drop has an edge: before it, as the sensor looks, is ground, and what lies deep begins at once; a ramp goes down slowly, and a
// near floor that a matcher gets wrong has no ground before it. Where it is not known whether points are mirrored, they are a drop
// only if no ground shows behind them, nor on both sides, and if a floor lies below: a wall or a window that stands there may be
// the image of one above.
@group(0) @binding(0) var<uniform> drop_params: DropParams;
@group(0) @binding(1) var<storage, read> drop_marks: array<u32>;
@group(0) @binding(2) var<storage, read> drop_cells: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> drop_said: array<u32>;
@group(0) @binding(6) var<storage, read> ground_now: array<vec4<f32>>;

// Share of a cell's votes for a drop.
const DROP_SHARE = 0.7;
// Messages, more than speak against it, that make a cell known as ground.
const KNOWN_AFTER = 3;
// A walk across cells goes so far a step, metres, or a cell. So far an edge may take to become deep; so many steps, behind a drop
// and on its sides, ground speaks against it; so many, before and behind, its floor is looked for.
const STEP_M = 0.05;
const MOST_SHALLOW_M = 0.15;
const MOST_EDGE_STEPS = 80u;
const BEHIND_STEPS = 30u;
const BESIDE_STEPS = 8u;
const LEVEL_BEFORE = 6u;
const LEVEL_STEPS = 16u;
// A floor is level: cells that show it; how much less heights vary, as a share of the mean, than distances do; deeper than this it
// may be the image of a ceiling.
const LEAST_LEVEL = 4.0;
const LEVEL_RATIO = 0.7;
const DEEPEST_LEVEL_M = 2.0;

// Votes of a cell.
struct Votes {
    ground: u32,
    shallow: u32,
    drop: u32,          // open and unsure
    unsure: u32,
    mirrored: u32,
    all: u32,
    depth_m: f32,       // mean of what is deep
}

fn votes_of(cell: u32) -> Votes {
    if cell == NO_CELL {
        return Votes(0u, 0u, 0u, 0u, 0u, 0u, 0.0);
    }
    let first = MARK_WORDS * cell;
    let low = vec3(drop_marks[first], drop_marks[first + 1u], drop_marks[first + 2u]);
    let counts = low & vec3(0xffffu);
    let next = low >> vec3(16u);
    let deep = counts.y + next.y;
    let all = counts.x + next.x + deep + counts.z + next.z;
    let depth_m = f32(drop_marks[first + 3u]) / (DEPTH_STEPS_PER_M * f32(max(deep, 1u)));
    return Votes(counts.x, next.x, deep, next.y, counts.z, all, depth_m);
}

// Messages that showed a drop, less those that showed the ground.
fn known_of(cell: u32) -> i32 {
    let side = drop_params.side;
    if cell == NO_CELL {
        return 0;
    }
    let slot = slot_of(cell % side, cell / side, drop_params.origin_slot_x, drop_params.origin_slot_y, side);
    return bitcast<i32>(drop_cells[slot].x);
}

fn is_ground(cell: u32, votes: Votes) -> bool {
    if 2u * votes.ground > votes.all {
        return true;
    }
    return votes.drop <= votes.ground && known_of(cell) <= -KNOWN_AFTER;
}

fn step_m() -> f32 {
    return max(STEP_M, drop_params.resolution_m);
}

fn is_ground_at(at: vec2<f32>) -> bool {
    let cell = cell_of(at);
    return is_ground(cell, votes_of(cell));
}

// Votes for a drop in the cell and those around it.
fn votes_around(at: vec2<f32>) -> u32 {
    var sum = 0u;
    for (var k = 0u; k < 9u; k++) {
        let off = drop_params.resolution_m * (vec2(f32(k % 3u), f32(k / 3u)) - 1.0);
        sum += votes_of(cell_of(at + off)).drop;
    }
    return sum;
}

// Whether ground, or what is known to be a drop, begins the way to a place, and what is deep begins there at once.
fn has_edge(at: vec2<f32>, away: vec2<f32>) -> bool {
    var shallow = 0.0;
    let most = max(MOST_SHALLOW_M, step_m()) + 0.5 * step_m();
    let steps = u32(min(drop_params.edge_m, length(at - sensor_in_window().xy)) / step_m());
    for (var k = 1u; k < MOST_EDGE_STEPS; k++) {
        let cell = cell_of(at - f32(k) * step_m() * away);
        if k > steps || cell == NO_CELL {
            break;
        }
        let votes = votes_of(cell);
        if is_ground(cell, votes) || known_of(cell) >= i32(drop_params.drops_after) {
            return shallow <= most;
        }
        shallow += select(0.0, step_m(), 2u * votes.shallow > votes.all);
    }
    return false;
}

// Whether what is deep around a place, along the way, is a level floor and no wall, and not as deep as a ceiling is high.
fn is_level(at: vec2<f32>, away: vec2<f32>) -> bool {
    let eye = sensor_in_window();
    let eye_m = height_of(eye);
    var count = 0.0;
    var heights = vec2(0.0);
    var distances = vec2(0.0);
    for (var k = 0u; k < LEVEL_STEPS; k++) {
        let place = at + (f32(k) - f32(LEVEL_BEFORE)) * step_m() * away;
        let votes = votes_of(cell_of(place));
        if votes.drop > 0u {
            let depth = votes.depth_m;
            let distance = length(place - eye.xy) * (eye_m + depth) / max(eye_m, 1.0e-3);
            count += 1.0;
            heights += vec2(depth, depth * depth);
            distances += vec2(distance, distance * distance);
        }
    }
    if count < LEAST_LEVEL {
        return false;
    }
    let mean = vec2(heights.x, distances.x) / count;
    let variance = max(vec2(heights.y, distances.y) / count - mean * mean, vec2(0.0));
    let relative = variance / max(mean * mean, vec2(1.0e-6));
    return relative.x < LEVEL_RATIO * LEVEL_RATIO * relative.y && mean.x < DEEPEST_LEVEL_M;
}

// Whether ground shows behind a place, as the sensor looks, or close by on both sides of it; behind what is not level, mirror images
// say the same.
fn is_in_ground(at: vec2<f32>, away: vec2<f32>, level: bool) -> bool {
    let across = vec2(-away.y, away.x);
    var sides = vec3(false);
    for (var k = 1u; k < BEHIND_STEPS + 1u; k++) {
        let step = f32(k) * step_m();
        let behind = cell_of(at + step * away);
        let votes = votes_of(behind);
        let image = !level && 2u * votes.mirrored > votes.all;
        let beside = k <= BESIDE_STEPS;
        sides |= vec3(
            is_ground(behind, votes) || image,
            beside && is_ground_at(at + step * across),
            beside && is_ground_at(at - step * across),
        );
    }
    return sides.x || (sides.y && sides.z);
}

@compute @workgroup_size(16, 4)
fn judge(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = drop_params.side;
    if id.x >= side || id.y >= side {
        return;
    }
    let cell = id.y * side + id.x;
    let votes = votes_of(cell);
    let at = (vec2(f32(id.x), f32(id.y)) + 0.5) * drop_params.resolution_m;
    let off = at - sensor_in_window().xy;
    let away = off / max(length(off), 1.0e-6);
    var says = select(0u, SAYS_GROUND, 2u * votes.ground > votes.all);
    let falls = votes.drop > 0u && f32(votes.drop) >= DROP_SHARE * f32(votes.all);
    // Loops that stand for an `if`, as in lib/drops/vote: few cells get here.
    for (var ask = 0u; ask < select(0u, 1u, falls); ask++) {
        var drops = votes_around(at) >= drop_params.least_votes && has_edge(at, away);
        for (var doubt = 0u; doubt < select(0u, 1u, drops && 2u * votes.unsure > votes.drop); doubt++) {
            drops = !is_in_ground(at, away, is_level(at, away));
        }
        if drops {
            says = SAYS_DROP | (u32(votes.depth_m * DEPTH_STEPS_PER_M) << SAID_SHIFT);
        }
    }
    drop_said[cell] = says;
}
