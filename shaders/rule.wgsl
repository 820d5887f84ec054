// Decides every cell of the window by the rule, from what the layers say: cost, row, sensor and age in one word.
// spec 4 §2 (the rule), §3 (age), §4 (the word); spec 6 §2 (drops).
struct RuleParams {
    fresh_since: array<vec4<u32>, 5>,   // by sensor + 1: the tick before which its evidence is stale
    side: u32,
    origin_slot_x: u32,
    origin_slot_y: u32,
    now: u32,                           // the newest tick
    cell_timeout: u32,                  // ticks after which any evidence is stale; 0: never
    height_min_m: f32,                  // lower edge of the height band above the ground
    pad0: u32,
    pad1: u32,
}

// What a layer says of a cell.
struct Said {
    state: u32,     // bits of the rule
    tick: u32,      // of its last evidence
    sensor: u32,    // + 1; 0: none
}

// Heights above the ground, metres: where a camera was hit, or between which beams crossed.
struct Span {
    low_m: f32,
    high_m: f32,
    gap_m: f32,     // largest gap between neighbouring beams
}

@group(0) @binding(0) var<uniform> rule_params: RuleParams;
@group(0) @binding(5) var<storage, read_write> verdicts: array<u32>;

const TICKS_PER_TENTH = 10u;

fn age(said: Said) -> u32 {
    return max(rule_params.now, said.tick) - said.tick;
}

fn is_stale(said: Said) -> bool {
    let old = rule_params.cell_timeout != 0u && age(said) > rule_params.cell_timeout;
    return said.tick < fresh_since_of(said.sensor) || old;
}

// Whether beams surely crossed within REFUTING_WITHIN_M of an end of the hits: the outermost beam did, or it lies farther
// out and beams behind it lie so near each other that one of them did.
fn meets_end(outermost_beyond_m: f32, gap_m: f32) -> bool {
    return abs(outermost_beyond_m) <= REFUTING_WITHIN_M
        || (outermost_beyond_m > 0.0 && gap_m <= 2.0 * REFUTING_WITHIN_M);
}

// Whether beams crossed the cell at the heights of the camera's hits.
fn is_refuted(hits: Span, beams: Span) -> bool {
    return beams.low_m <= beams.high_m && beams.gap_m <= REFUTING_GAP_M
        && meets_end(hits.low_m - beams.low_m, beams.gap_m)
        && meets_end(beams.high_m - hits.high_m, beams.gap_m);
}

// Ticks in whole tenths of a second, up to the most that a word holds. Half a tick keeps the product off whole numbers, so that it
// is exact; a division of integers is slow on software drivers.
fn tenths(ticks: u32) -> u32 {
    return u32((f32(min(ticks, MOST_AGE * TICKS_PER_TENTH)) + 0.5) / f32(TICKS_PER_TENTH));
}

// The verdict by a row of the rule, as a word of it, and the evidence of a layer.
fn worded(row: u32, said: Said) -> u32 {
    let age_tenths = select(0u, tenths(age(said)), said.sensor != 0u);
    return verdict_of(row & 0xffu, (row >> 8u) & 0xfu, said.sensor, age_tenths);
}

fn decide(panes: Said, lidars: Said, cameras: Said) -> u32 {
    let row = rule_of(panes.state, lidars.state, cameras.state);
    let layer = (row >> 12u) & 3u;
    var by = Said(0u, 0u, 0u);
    if layer == LAYER_PANES {
        by = panes;
    } else if layer == LAYER_LIDAR {
        by = lidars;
    } else if layer == LAYER_CAMERA {
        by = cameras;
    }
    var stale = (row >> 16u) == 1u && is_stale(by);
    // A camera that saw through the cell stands for a lidar that no longer can.
    if stale && layer == LAYER_LIDAR && cameras.state == CAMERA_FREE && !is_stale(cameras) {
        by = cameras;
        stale = false;
    }
    return worded(select(row, STALE, stale), by);
}

@compute @workgroup_size(16, 4)
fn rule(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = rule_params.side;
    if id.x >= side || id.y >= side {
        return;
    }
    let slot = slot_of(id.x, id.y, rule_params.origin_slot_x, rule_params.origin_slot_y, side);
    let cameras = cameras_say(slot);
    var lidars = lidars_say(slot);
    if (cameras.state & CAMERA_OCCUPIED) != 0u && lidars.state == LIDAR_FREE && lidars.tick > cameras.tick
        && is_refuted(hits_of(slot, rule_params.height_min_m), crossed(slot)) {
        lidars.state |= LIDAR_REFUTING;
    }
    let verdict = decide(panes_say(slot), lidars, cameras);
    let drop = drops_say(slot);
    let drops = drop.state != 0u && verdict_cost(verdict) != COST_LETHAL;
    verdicts[id.y * side + id.x] = select(verdict, worded(DROP, drop), drops);
}
