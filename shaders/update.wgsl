// Turns a frame's evidence into occupancy and state, once per cell, and marks when, by whom and how the cell was seen.
// spec 1 §3 (occupancy, hysteresis, confirmations), §4 (temporal rejection), §9 (evidence), spec 4 §1 (marks, several cameras).
// Needs one of lib/fusion: how a look changes a cell.
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

// Whether what is kept counts less the longer ago it is, else by the number of observations.
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

// What a frame shows of a cell.
struct Look {
    hit: bool,
    seen: bool,     // seen through, without hits
    count: u32,     // hits
}

// Whether the cell was seen since: then this frame changes nothing of it.
fn is_late(slot: u32) -> bool {
    return cell_marks[slot].x > cell_marks_params.tick;
}

// Whether enough of the frames that observed the cell hit it, the newest lowest in `history` (spec 1 §4).
fn hit_often(history: u32) -> bool {
    let recent = history & ((1u << update_params.temporal_window) - 1u);
    return countOneBits(recent) >= update_params.temporal_hits;
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
    let late = is_late(slot);
    let hit = !late && count >= update_params.min_hits;
    let look = Look(hit, !hit && !late && is_seen_through(i), count);
    var cell = to_cell(cells[slot]);
    var e = UNSEEN;
    if look.hit || look.seen {
        let had_hits = cell.top > FLOOR;
        e = fuse(i, slot, look, &cell);
        mark(slot, hit, cell_hits[i], had_hits, cell.top > FLOOR);
        cells[slot] = from_cell(cell);
    }
    if keep_grids {
        evidence[i] = e;
        occupancy[i] = occupancy_of(cell);
    }
    state[i] = see_state(cell.state) | select(0u, WAS_HIT, look.hit) | select(0u, WAS_SEEN_THROUGH, look.seen);
}
