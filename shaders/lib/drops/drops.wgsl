// What the passes of drops share (spec 6 §2): parameters, cells, the records of the layer, votes.
struct DropParams {
    window_from_sensor_x: vec4<f32>,    // rows of the transform, as the passes before count
    window_from_sensor_y: vec4<f32>,
    window_from_sensor_z: vec4<f32>,
    lens_a: vec4<f32>,                  // as lib/lens takes them
    lens_b: vec4<f32>,
    focal_px: vec2<f32>,
    centre_px: vec2<f32>,
    width: u32,                         // of the image
    measured: u32,                      // pixels of it, or points of a scan
    columns: u32,                       // pixels that are looked at, in a row, or points
    rows: u32,
    stride: u32,                        // pixels, or points, from one that is looked at to the next
    side: u32,
    origin_slot_x: u32,
    origin_slot_y: u32,
    resolution_m: f32,
    range_m: f32,                       // farthest place that counts, along the ground
    drop_m: f32,
    floor_m: f32,                       // what lies this little above the ground is ground
    tau: f32,
    tick: u32,
    sensor: u32,                        // + 1
    least_votes: u32,                   // in a cell and around it, that make a drop in one message
    edge_m: f32,                        // how far before a drop the ground must be seen
    drops_after: u32,                   // messages, more than speak against it, that make a drop
    pad0: u32,
    pad1: u32,
}

// A cell of the layer `drop_cells`.
//   x: messages that show a drop less those that show the ground, an i32; y: tick of the last of them, 0: none; z: sensor + 1, as
//   in other records, and DROPS; w: how far below the ground it was seen, in steps of lib/record
const DROPS = 1u;

// Votes of a message for a cell of the ground, by what the rays do that meet the ground's height there, in the buffer `drop_marks`,
// four words: those that end on the ground, and above as deep as a drop; those that end deeper where nothing is mirrored, and where
// that is not known; mirror images, and what neighbours do not bear out, 16 bits each. The last: sum of the depths of the third
// and the fourth, in steps.
const MARK_WORDS = 4u;
const GROUND = 0u;
const SHALLOW = 1u;
const OPEN = 2u;
const UNSURE = 3u;
const MIRRORED = 4u;
const ROUGH = 5u;
const DEPTH_STEPS_PER_M = 1024.0;
const MOST_DEPTH_M = 40.0;

// What a message says of a cell, in the buffer `drop_said`: nothing, or one of these, and a drop's depth in steps above bit 2.
const SAYS_GROUND = 1u;
const SAYS_DROP = 2u;
const SAID_SHIFT = 2u;

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
