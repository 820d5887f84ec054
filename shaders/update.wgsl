// Turns a frame's evidence into occupancy and state, once per cell, and marks when, by whom and how the cell was seen.
// spec 1 §3 (occupancy, hysteresis, confirmations), §4 (temporal rejection), spec 4 §1 (marks, occupancy by several cameras).
struct UpdateParams {
    side: u32,
    origin_slot_x: u32,
    origin_slot_y: u32,
    min_hits: u32,
    confirmations: u32,
    temporal_window: u32,
    temporal_hits: u32,
    lambda: f32,
    occupied_threshold: f32,
    free_threshold: f32,
    weight_scale: f32,
    pad: u32,
}

struct CellMarksParams {
    tick: u32,
    sensor: u32,                    // + 1
    log2_lambda_per_tick: f32,      // of the share of the old occupancy that a tick leaves
    pad: u32,
}

// Whether the old occupancy counts less the longer ago it is, else by the number of observations.
override timed: bool = false;
// Whether evidence and occupancy are kept for the host.
override keep_grids: bool = true;
// Whether back_project keeps the lowest hits.
override lowest: bool = false;

@group(0) @binding(0) var<uniform> update_params: UpdateParams;
@group(0) @binding(1) var<storage, read> cell_hits: array<CellHits>;
@group(0) @binding(2) var<storage, read> seen_through: array<u32>;
@group(0) @binding(3) var<storage, read_write> cells: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> evidence: array<f32>;
@group(0) @binding(5) var<storage, read_write> occupancy: array<f32>;
@group(0) @binding(6) var<storage, read_write> state: array<u32>;
@group(0) @binding(7) var<uniform> cell_marks_params: CellMarksParams;
// When, by whom and how a cell was last seen by a camera.
//   x: tick; y: lowest hit above the height band's lower edge in bits 0-15, in steps of 1/1024 m, 0 where it is not known;
//   mean R of the last hit in bits 16-23, in 1/255; sensor + 1
@group(0) @binding(8) var<storage, read_write> cell_marks: array<vec2<u32>>;

const UNSEEN = -1.0;

// e of the spec: mean weight of the hits, 0 where seen through, UNSEEN where nothing may be said.
fn evidence_of(i: u32, count: u32, hit: bool, seen: bool, history: u32) -> f32 {
    if !hit {
        return select(UNSEEN, 0.0, seen);
    }
    let recent = history & ((1u << update_params.temporal_window) - 1u);
    if countOneBits(recent) < update_params.temporal_hits {
        return UNSEEN;
    }
    if !weighted || gated {
        return 1.0;
    }
    return f32(cell_hits[i].weight) / (f32(count) * update_params.weight_scale);
}

// Occupied from occupied_threshold up and until below free_threshold; free only by being seen through.
fn next_state(old: u32, p: f32, confirmed: bool, seen: bool) -> u32 {
    if old == OCCUPIED && p >= update_params.free_threshold {
        return OCCUPIED;
    }
    if p >= update_params.occupied_threshold && confirmed {
        return OCCUPIED;
    }
    if seen && p < update_params.free_threshold {
        return FREE;
    }
    return select(old, UNKNOWN, old == OCCUPIED);
}

// Whether the cell was seen since: then this frame changes nothing of it.
fn is_late(slot: u32) -> bool {
    return cell_marks[slot].x > cell_marks_params.tick;
}

fn lambda_of(slot: u32) -> f32 {
    let last = cell_marks[slot].x;
    if !timed || last == 0u {
        return update_params.lambda;
    }
    let since = max(cell_marks_params.tick, last) - last;
    return exp2(cell_marks_params.log2_lambda_per_tick * f32(since));
}

// Mean R of the frame's hits in 1/255.
fn mean_reliability(hits: CellHits) -> u32 {
    if !weighted || (gated && !lowest) {
        return 255u;
    }
    let mean = f32(hits.weight) / (f32(max(hits.count, 1u)) * update_params.weight_scale);
    return u32(clamp(mean, 0.0, 1.0) * 255.0 + 0.5);
}

// Lowest hit of the frame.
fn low_of(hits: CellHits) -> u32 {
    return u32(min(steps_to_height(max(~hits.low, FLOOR + 1u)) * RECORD_STEPS_PER_M, MOST_RECORD_STEPS));
}

// Marks a cell that was hit, or else seen through. `had_hits`: hits before this frame are remembered; `keeps_hits`: they stay so
// when it is seen through.
fn mark(slot: u32, hit: bool, hits: CellHits, had_hits: bool, keeps_hits: bool) {
    var low = 0u;
    var reliability = select(0u, mean_reliability(hits), hit);
    if lowest {
        let old = cell_marks[slot].y;
        let kept = old & 0xffffu;
        let hit_low = select(low_of(hits), min(low_of(hits), kept), had_hits);
        low = select(select(0u, kept, keeps_hits), hit_low, hit);
        reliability = select(select(0u, (old >> 16u) & 0xffu, keeps_hits), reliability, hit);
    }
    let sensor = cell_marks_params.sensor << SENSOR_SHIFT;
    cell_marks[slot] = vec2(cell_marks_params.tick, low | (reliability << 16u) | sensor);
}

@compute @workgroup_size(16, 4)
fn update(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = update_params.side;
    if id.x >= side || id.y >= side {
        return;
    }
    let i = id.y * side + id.x;
    let slot = slot_of(id.x, id.y, update_params.origin_slot_x, update_params.origin_slot_y, side);
    let count = cell_hits[i].count;
    var cell = to_cell(cells[slot]);
    let late = is_late(slot);
    let hit = !late && count >= update_params.min_hits;
    let seen = !hit && !late && seen_through[i] == 1u;
    var run = cell.state >> 8u;
    var now = cell.state & 3u;
    var e = UNSEEN;
    if hit || seen {
        cell.history = (cell.history << 1u) | select(0u, 1u, hit);
        run = select(0u, min(run + 1u, 255u), hit);
        e = evidence_of(i, count, hit, seen, cell.history);
    }
    if e >= 0.0 {
        let lambda = lambda_of(slot);
        cell.occupancy = lambda * cell.occupancy + (1.0 - lambda) * e;
        now = next_state(now, cell.occupancy, run >= update_params.confirmations, seen);
    }
    if hit || seen {
        mark(slot, hit, cell_hits[i], cell.top > FLOOR, now != FREE);
        cell.top = select(max(cell.top, cell_hits[i].top), select(cell.top, 0u, now == FREE), seen);
        cell.state = now | (run << 8u);
        cells[slot] = from_cell(cell);
    }
    if keep_grids {
        evidence[i] = e;
        occupancy[i] = cell.occupancy;
    }
    state[i] = now | select(0u, WAS_HIT, hit) | select(0u, WAS_SEEN_THROUGH, seen);
}
