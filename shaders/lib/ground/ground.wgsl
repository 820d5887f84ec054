// What the passes of the ground share (spec 6 §2): parameters, samples, planes, what is kept.
// Samples and planes count from the sensor, in the map's axes: n . p = d with n upwards, so that d < 0 for what lies below it.
struct GroundParams {
    local_from_sensor_x: vec4<f32>,     // rows of the transform; w: the sensor from the local origin
    local_from_sensor_y: vec4<f32>,
    local_from_sensor_z: vec4<f32>,
    base: vec4<f32>,                    // the robot's base from the sensor; w: how it is known
    zero: vec4<f32>,                    // corner of cell (0, 0), and the height that the passes count from, local
    focal_px: vec2<f32>,
    centre_px: vec2<f32>,
    width: u32,                         // of the image
    measured: u32,                      // pixels of it, or points of a scan
    columns: u32,                       // of samples
    rows: u32,
    stride: u32,                        // pixels, or points, to a sample
    tick: u32,
    keep_ticks: u32,                    // how long a plane is believed that is not seen
    sensor: u32,
    sensors: u32,
    has_map: u32,                       // 1: tf gives the sensor in a map, so that z is up and the stated ground counts
    tau: f32,
    most_slope: f32,                    // tangent of the steepest ground
    stated_z: f32,                      // stated ground, local
    square_m: f32,                      // side of the squares by which planes are measured
    agrees_m: f32,                      // where a plane is this near the stated ground, that is taken
    least_height_m: f32,                // of the sensor above the ground
}

// How the base is known: it is the sensor, or assumed to stand on the stated ground under it, or known.
const BASE_UNKNOWN = 0.0;
const BASE_ASSUMED = 1.0;
const BASE_KNOWN = 2.0;

// Samples in rows of their texture.
const SAMPLE_ROW = 64u;
const MOST_SAMPLES = 2048u;
// Planes that are drawn for a message.
const HYPOTHESES = 128u;
// A plane that is none.
const NO_PLANE = vec4<f32>(0.0, 0.0, 0.0, 1.0e9);

// Samples lie at least this far below the sensor, and at most this far around it, metres.
const LEAST_BELOW_M = 0.05;
const FARTHEST_M = 20.0;
// How near a plane a sample is on it: so much, and a share of its distance.
const TOLERANCE_M = 0.03;
const TOLERANCE_PER_M = 0.01;
// A sample lies so many times its tolerance below the sensor: else what is nearly level with it is on a plane at any height.
const LEAST_TOLERANCES = 2.0;

// A sample: its place, and how near a plane it is on it; 0: there is none.
fn sample_of(place: vec3<f32>) -> vec4<f32> {
    let tolerance = TOLERANCE_M + TOLERANCE_PER_M * length(place);
    if !(place.z < -LEAST_BELOW_M && -place.z > LEAST_TOLERANCES * tolerance && length(place.xy) < FARTHEST_M) {
        return vec4(0.0);
    }
    return vec4(place, tolerance);
}

fn sample_texel(number: u32) -> vec2<u32> {
    return vec2(number % SAMPLE_ROW, number / SAMPLE_ROW);
}

fn turned(v: vec3<f32>) -> vec3<f32> {
    return vec3(
        dot(ground_params.local_from_sensor_x.xyz, v),
        dot(ground_params.local_from_sensor_y.xyz, v),
        dot(ground_params.local_from_sensor_z.xyz, v),
    );
}

// The sensor from the local origin.
fn sensor_place() -> vec3<f32> {
    return vec3(ground_params.local_from_sensor_x.w, ground_params.local_from_sensor_y.w, ground_params.local_from_sensor_z.w);
}
