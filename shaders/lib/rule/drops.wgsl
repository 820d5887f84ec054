// The layer of drops, for the rule. Needs lib/record, the rule.
@group(0) @binding(6) var<storage, read> drop_cells: array<vec4<u32>>;

// Tick and sensor of a cell that drops; state 0: it does not.
fn drops_say(slot: u32) -> Said {
    let drop = drop_cells[slot];
    return Said(drop.z & 1u, drop.y, sensor_of(drop.z));
}
