// Marks places below the ground. Needs lib/drops/drops, lib/drops/height, drop_cells and drop_marks.

// How much deeper than drop_m a place must lie for each metre of distance.
const DEEPER_PER_M = 0.01;
// No sensor measures farther.
const FARTHEST_M = 300.0;
// Messages that showed the ground in a cell before it is known there.
const KNOWN_AFTER = 3u;

// Turns of a loop that stands for an `if`: drivers that run both sides of a branch under a mask leave a loop as soon as no
// lane needs it.
fn turns_if(condition: bool) -> u32 {
    return select(0u, 1u, condition);
}

// Whether a place of that height above the ground is a drop, seen from above the ground and near enough.
fn is_deep(place: vec3<f32>, height: f32) -> bool {
    let away = length(crossing_of(place, height) - sensor_in_window().xy);
    if !(length(place - sensor_in_window()) < FARTHEST_M) {
        return false;
    }
    return height < -(drop_params.drop_m + DEEPER_PER_M * away) && ground_now[1].y > 0.0 && away < drop_params.range_m;
}

// Where the ray to a place below the ground crosses the ground.
fn crossing_of(place: vec3<f32>, height: f32) -> vec2<f32> {
    let eye = sensor_in_window();
    let eye_m = height_of(eye);
    return eye.xy + (place.xy - eye.xy) * (eye_m / max(eye_m - height, 1.0e-6));
}

fn is_known_ground(cell: u32) -> bool {
    let side = drop_params.side;
    let slot = slot_of(cell % side, cell / side, drop_params.origin_slot_x, drop_params.origin_slot_y, side);
    return drop_cells[slot].w >= KNOWN_AFTER;
}

// The cell where a ray leaves the ground's height is the edge as it is seen, and the one where it ends lies below it.
fn mark(crossing: vec2<f32>, end: vec2<f32>, explained: bool) {
    let end_cell = cell_of(end);
    let crossing_cell = cell_of(crossing);
    if explained {
        if end_cell != NO_CELL {
            atomicOr(&drop_marks[2u * end_cell], MIRRORED);
        }
        return;
    }
    if end_cell != NO_CELL {
        atomicAdd(&drop_marks[2u * end_cell], 1u);
    }
    if crossing_cell != NO_CELL && crossing_cell != end_cell {
        atomicAdd(&drop_marks[2u * crossing_cell], 1u);
    }
}
