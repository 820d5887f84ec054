// The occupancy layer, for the rule. Needs lib/cell, lib/record, the rule and the height band's lower edge.
@group(0) @binding(1) var<storage, read> cells: array<vec4<u32>>;
@group(0) @binding(2) var<storage, read> cell_marks: array<vec2<u32>>;

fn cameras_say(slot: u32) -> Said {
    let marks = cell_marks[slot];
    if marks.x == 0u {
        return Said(CAMERA_UNKNOWN, 0u, 0u);
    }
    let state = camera_state_of(see_state(to_cell(cells[slot]).state));
    // A camera alone is the first sensor, and nobody doubts it: a read less.
    if ALONE {
        return Said(state, marks.x, 1u);
    }
    let doubtful = state == CAMERA_OCCUPIED && ((marks.y >> 16u) & 0xffu) < DOUBTFUL_BELOW;
    return Said(state | select(0u, CAMERA_DOUBTFUL, doubtful), marks.x, sensor_of(marks.y));
}

fn hits_of(slot: u32, height_min_m: f32) -> Span {
    let low_m = height_min_m + f32(cell_marks[slot].y & 0xffffu) / RECORD_STEPS_PER_M;
    let top = to_cell(cells[slot]).top;
    let high_m = height_min_m + select(0.0, steps_to_height(max(top, FLOOR + 1u)), top > FLOOR);
    return Span(low_m, max(low_m, high_m), 0.0);
}
