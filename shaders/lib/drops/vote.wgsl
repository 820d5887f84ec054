// Votes of rays for the cells in which they meet the ground's height. Needs lib/drops/drops, lib/drops/height and drop_marks.

// How much deeper than drop_m a place must lie for each metre of distance.
const DEEPER_PER_M = 0.01;
// What lies below the ground by less than this share of drop_m is ground.
const GROUND_SHARE = 0.5;
// No sensor measures farther.
const FARTHEST_M = 300.0;

// What a sensor sees of the place at which a thing would stand whose mirror image a point may be: it does not look there, it
// looks past it, or something is there or before it.
const NOT_SEEN = 0u;
const LOOKED_PAST = 1u;
const IN_THE_WAY = 2u;

// Turns of a loop that stands for an `if`: drivers that run both sides of a branch under a mask leave a loop as soon as no
// lane needs it.
fn turns_if(condition: bool) -> u32 {
    return select(0u, 1u, condition);
}

// Where a ray meets the ground's height, and what it does there: GROUND, SHALLOW, or OPEN where it goes on to a place as deep as a
// drop, of which the rest is asked; ROUGH: it does not meet it, or too far away.
struct Crossing {
    at: vec2<f32>,
    does: u32,
    height: f32,        // of its end, above the ground
}

fn crossing_of(place: vec3<f32>) -> Crossing {
    let eye = sensor_in_window();
    let eye_m = height_of(eye);
    let height = height_of(place);
    let at = eye.xy + (place.xy - eye.xy) * (eye_m / max(eye_m - min(height, 0.5 * eye_m), 1.0e-6));
    let away = length(at - eye.xy);
    let meets = length(place - eye) < FARTHEST_M && height < drop_params.floor_m && eye_m > drop_params.floor_m
        && away < drop_params.range_m;
    let deep = height < -(drop_params.drop_m + DEEPER_PER_M * away);
    let does = select(select(SHALLOW, OPEN, deep), GROUND, height > -GROUND_SHARE * drop_params.drop_m);
    return Crossing(at, select(ROUGH, does, meets), height);
}

// The place as far above the ground as `place` lies below it, from the sensor, in the window's axes.
fn mirrored(place: vec3<f32>, height: f32) -> vec3<f32> {
    return place - 2.0 * height * ground_now[0].xyz - sensor_in_window();
}

// The vote of what is deep.
fn vote_by(seen: u32) -> u32 {
    return select(select(UNSURE, OPEN, seen == LOOKED_PAST), MIRRORED, seen == IN_THE_WAY);
}

fn vote(crossing: Crossing, kind: u32) {
    let cell = cell_of(crossing.at);
    if cell == NO_CELL {
        return;
    }
    let first = MARK_WORDS * cell;
    atomicAdd(&drop_marks[first + kind / 2u], select(1u, 0x10000u, (kind & 1u) == 1u));
    if kind == OPEN || kind == UNSURE {
        atomicAdd(&drop_marks[first + 3u], u32(min(-crossing.height, MOST_DEPTH_M) * DEPTH_STEPS_PER_M));
    }
}
