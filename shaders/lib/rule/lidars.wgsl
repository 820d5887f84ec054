// The solidity layer, for the rule. Needs lib/record, the rule.
@group(0) @binding(3) var<storage, read> solid_cells: array<vec4<u32>>;

fn lidars_say(slot: u32) -> Said {
    let solid = solid_cells[slot];
    if solid.y == 0u {
        return Said(LIDAR_UNKNOWN, 0u, 0u);
    }
    return Said(lidar_state_of(solid.x & 0xffu), solid.y, sensor_of(solid.w));
}

// Where no beam's height is known, the span is empty: its lower end is above its upper one.
fn crossed(slot: u32) -> Span {
    let solid = solid_cells[slot];
    let low = f32(solid.z & 0xffffu) / RECORD_STEPS_PER_M - CROSSING_ZERO_M;
    let high = f32(solid.z >> 16u) / RECORD_STEPS_PER_M - CROSSING_ZERO_M;
    let gap = f32(solid.w & 0xffffu) / RECORD_STEPS_PER_M;
    if solid.z == 0u {
        return Span(1.0, 0.0, 0.0);
    }
    return Span(low, high, gap);
}
