// Finds the mirror images in a glossy floor. They lie below the ground, the floor is seen beside the place where their beam meets
// it, and the sensor does not look past the place that is mirrored. spec 6 §2: a point mirrored below the floor lies on a ray that
// crosses the floor first. Such an image has no pane, also where one mirrors it as well: that would leave it below the floor. What
// is outside stays so: the ground there may lie lower.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var<uniform> ground_params: GroundParams;
@group(0) @binding(2) var<storage, read> ground_now: array<vec4<f32>>;
@group(0) @binding(3) var placed: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(4) var row_texels: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(5) var<storage, read> beam_cells: array<u32>;
@group(0) @binding(6) var<storage, read_write> classes: array<u32>;
@group(0) @binding(7) var<storage, read_write> glass_counters: array<atomic<u32>>;

// How far below the ground a point lies at least, and for each metre of way along it.
const BELOW_M = 0.1;
const BELOW_PER_M = 0.01;
// How near the ground a return is the floor's, and for each metre of way.
const FLOOR_M = 0.05;
const FLOOR_PER_M = 0.005;
// Of the beams of the same row within this part of a turn to each side (1.2 degrees), or so many, some must show the floor, and some go
// below it, as the image of a thing is no single point.
const BESIDE_PARTS = 300u;
const LEAST_BESIDE = 4u;
const MOST_BESIDE = 16u;
const LEAST_FLOOR = 2u;
const LEAST_BELOW = 4u;

// Of a place in the lidar's frame.
fn height_of(p: vec3<f32>) -> f32 {
    let at = turned(p) + sensor_place() - ground_params.zero.xyz;
    return dot(ground_now[0], vec4(at, 1.0));
}

// A place as far above the ground as `p` lies below it.
fn above_ground(p: vec3<f32>, height: f32) -> vec3<f32> {
    let up = ground_now[0].xyz;
    let in_lidar = ground_params.local_from_sensor_x.xyz * up.x
        + ground_params.local_from_sensor_y.xyz * up.y
        + ground_params.local_from_sensor_z.xyz * up.z;
    return p - 2.0 * height * in_lidar;
}

fn is_below(height: f32, range_m: f32) -> bool {
    return height < -(BELOW_M + BELOW_PER_M * range_m);
}

// Whether a return along a beam, which falls by `falls` a metre from `eye_m`, is the floor's, and whether it lies below.
fn ends(word: u32, eye_m: f32, falls: f32) -> vec2<bool> {
    let range_m = f32(steps_in(word)) / RANGE_STEPS_PER_M;
    let height = eye_m - falls * range_m;
    let is_floor = abs(height) < FLOOR_M + FLOOR_PER_M * range_m;
    return vec2(word != NONE) & vec2(is_floor, is_below(height, range_m));
}

// Beams beside one, in its row: those that end on the floor, and those that end below it.
fn beside(place: u32, eye_m: f32, falls: f32) -> vec2<u32> {
    let column = place / glass_params.rows;
    let row = place - column * glass_params.rows;
    let reach = clamp(glass_params.columns / BESIDE_PARTS, LEAST_BESIDE, MOST_BESIDE);
    var at = column + glass_params.columns - reach;
    at = select(at, at - glass_params.columns, at >= glass_params.columns);
    var count = vec2(0u);
    for (var k = 0u; k < 2u * MOST_BESIDE + 1u; k++) {
        if k > 2u * reach {
            break;
        }
        let cell = 2u * (at * glass_params.rows + row);
        let found = ends(beam_cells[cell], eye_m, falls) | ends(beam_cells[cell + 1u], eye_m, falls);
        count += select(vec2(0u), vec2(1u), found);
        at = next_column(at);
    }
    return count;
}

fn is_image(p: vec3<f32>, place: u32, height: f32) -> bool {
    let eye_m = height_of(vec3(0.0));
    let falls = (eye_m - height) / length(p);
    if !(eye_m > FLOOR_M) || any(beside(place, eye_m, falls) < vec2(LEAST_FLOOR, LEAST_BELOW)) {
        return false;
    }
    return !against_measured(above_ground(p, height)).beyond;
}

fn look_at(index: u32) {
    let label = classes[index];
    let kind = label & 0xffu;
    let texel = textureLoad(placed, placed_texel(index), 0u);
    let number = u32(texel.w);
    let height = height_of(texel.xyz);
    let below = number != 0u && is_below(height, length(texel.xyz));
    for (var once = 0u; once < turns_if(kind != UNLABELLED && kind != OUTSIDE && below); once++) {
        if is_image(texel.xyz, (number - 1u) / 2u, height) {
            classes[index] = label_of(REFLECTION, 0u);
            atomicSub(&glass_counters[COUNT_CLASSES + kind], 1u);
            atomicAdd(&glass_counters[COUNT_CLASSES + REFLECTION], 1u);
        }
    }
}

@compute @workgroup_size(64)
fn floor_images(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    // Only a floor that is seen mirrors.
    if !(ground_now[1].x > 0.5) {
        return;
    }
    let turns = turns_from(id.x, glass_params.points, 64u * groups.x);
    for (var turn = 0u; turn < turns; turn++) {
        look_at(id.x + 64u * groups.x * turn);
    }
}
