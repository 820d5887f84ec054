// Joins what a message says of drops with what is known of each cell: it takes several that agree, and the ground seen there
// speaks against it. spec 6 §2 (drop-offs).
@group(0) @binding(0) var<uniform> drop_params: DropParams;
@group(0) @binding(1) var<storage, read> drop_said: array<u32>;
@group(0) @binding(2) var<storage, read_write> drop_cells: array<vec4<u32>>;

// A drop stays until so many messages less show it, and what is known is no surer than so many.
const STAYS_PART = 2;
const MOST_KNOWN_PARTS = 2;

@compute @workgroup_size(16, 4)
fn decide(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = drop_params.side;
    if id.x >= side || id.y >= side {
        return;
    }
    let says = drop_said[id.y * side + id.x];
    let slot = slot_of(id.x, id.y, drop_params.origin_slot_x, drop_params.origin_slot_y, side);
    if says == 0u {
        return;
    }
    let old = drop_cells[slot];
    if old.y > drop_params.tick {
        return;
    }
    let drops = (says & SAYS_DROP) != 0u;
    let after = i32(drop_params.drops_after);
    let most = MOST_KNOWN_PARTS * after;
    let known = clamp(bitcast<i32>(old.x) + select(-1, 1, drops), -most, most);
    let limit = select(after, after / STAYS_PART, (old.z & DROPS) != 0u);
    let depth = select(old.w, says >> SAID_SHIFT, drops);
    let flag = select(0u, DROPS, known >= limit);
    drop_cells[slot] = vec4(
        bitcast<u32>(known),
        max(drop_params.tick, 1u),
        (drop_params.sensor << SENSOR_SHIFT) | flag,
        depth,
    );
}
