// Turns a frame's evidence into occupancy and state, once per cell.
// spec 1 §3 (occupancy, hysteresis, confirmations), §4 (temporal rejection), spec 4 §1 (occupancy by several cameras).
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

@group(0) @binding(0) var<uniform> update_params: UpdateParams;
@group(0) @binding(1) var<storage, read> cell_hits: array<CellHits>;
@group(0) @binding(2) var<storage, read> seen_through: array<u32>;
@group(0) @binding(3) var<storage, read_write> cells: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> evidence: array<f32>;
@group(0) @binding(5) var<storage, read_write> occupancy: array<f32>;
@group(0) @binding(6) var<storage, read_write> state: array<u32>;

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
    evidence[i] = e;
    occupancy[i] = cell.occupancy;
    state[i] = now | select(0u, WAS_HIT, hit) | select(0u, WAS_SEEN_THROUGH, seen);
}
