// What the passes of drops share (spec 6 §2): places more than drop_m below the ground, where it is not seen.
struct DropParams {
    window_from_sensor_x: vec4<f32>,    // rows of the transform, as the passes before count
    window_from_sensor_y: vec4<f32>,
    window_from_sensor_z: vec4<f32>,
    focal_px: vec2<f32>,
    centre_px: vec2<f32>,
    width: u32,                         // of the image
    measured: u32,                      // pixels of it, or points of a scan
    columns: u32,                       // pixels that are looked at, in a row, or points
    rows: u32,
    stride: u32,
    side: u32,
    origin_slot_x: u32,
    origin_slot_y: u32,
    resolution_m: f32,
    range_m: f32,                       // farthest place that counts, along the ground
    drop_m: f32,
    floor_m: f32,                       // what lies this near the ground is floor
    tau: f32,
    tick: u32,
    sensor: u32,                        // + 1
    min_points: u32,                    // that make a drop in one message
    keep_share: f32,                    // lambda
    threshold: f32,
    pad0: u32,
    pad1: u32,
}

// A cell of the layer `drop_cells`.
//   x: how surely it drops, in [0, 1], as a float; y: tick of what last spoke for or against it, 0: nothing did; z: sensor + 1, as
//   in other records, and DROPS; w: tick at which the ground was last seen in it, 0: never
const DROPS = 1u;

// What a message says of a cell, in the buffer `drop_marks`, two words: points below the ground that nothing explains, in bits
// 0-23 of the first; MIRRORED where such a point is explained. The second: 1 where the ground is seen.
const MIRRORED = 0x80000000u;
const COUNT_MASK = 0x00ffffffu;

const NO_CELL = 0xffffffffu;

// The cell of a place of the window; NO_CELL outside of it.
fn cell_of(at: vec2<f32>) -> u32 {
    let side = drop_params.side;
    let cell = floor(at / drop_params.resolution_m);
    if !(all(cell >= vec2(0.0)) && all(cell < vec2(f32(side)))) {
        return NO_CELL;
    }
    return u32(cell.y) * side + u32(cell.x);
}

fn in_window(place: vec3<f32>) -> vec3<f32> {
    let point = vec4(place, 1.0);
    return vec3(
        dot(drop_params.window_from_sensor_x, point),
        dot(drop_params.window_from_sensor_y, point),
        dot(drop_params.window_from_sensor_z, point),
    );
}

fn sensor_in_window() -> vec3<f32> {
    return vec3(drop_params.window_from_sensor_x.w, drop_params.window_from_sensor_y.w, drop_params.window_from_sensor_z.w);
}
