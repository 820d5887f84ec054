// Joins what a message says of drops with what is known of each cell: it takes several that agree, and the ground seen there
// speaks against it. spec 6 §2 (drop-offs); spec 1 §3 (the average over messages).
@group(0) @binding(0) var<uniform> drop_params: DropParams;
@group(0) @binding(1) var<storage, read> drop_marks: array<u32>;
@group(0) @binding(2) var<storage, read_write> drop_cells: array<vec4<u32>>;

// A cell drops from the threshold up, and until below this share of it.
const STAYS_SHARE = 0.7;
const MOST_KNOWN = 255u;

@compute @workgroup_size(16, 4)
fn decide(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = drop_params.side;
    if id.x >= side || id.y >= side {
        return;
    }
    let cell = id.y * side + id.x;
    let word = drop_marks[2u * cell];
    let points = word & COUNT_MASK;
    let ground = is_ground(cell);
    let slot = slot_of(id.x, id.y, drop_params.origin_slot_x, drop_params.origin_slot_y, side);
    if !ground && word == 0u {
        return;
    }
    let old = drop_cells[slot];
    if old.y > drop_params.tick || (!ground && points > 0u && points < drop_params.min_points) {
        return;
    }
    let drops = !ground && points > 0u;
    var sure = drop_params.keep_share * bitcast<f32>(old.x);
    var known = old.w;
    if drops {
        sure += 1.0 - drop_params.keep_share;
        known = max(known, 1u) - 1u;
    } else if ground {
        known = min(known + 1u, MOST_KNOWN);
    }
    let limit = drop_params.threshold * select(1.0, STAYS_SHARE, (old.z & DROPS) != 0u);
    let flag = select(0u, DROPS, sure >= limit);
    drop_cells[slot] = vec4(bitcast<u32>(sure), max(drop_params.tick, 1u), (drop_params.sensor << SENSOR_SHIFT) | flag, known);
}
