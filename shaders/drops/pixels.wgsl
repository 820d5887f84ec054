// Finds pixels of a depth image that lie below the ground where nothing explains it: neither the ground, seen where their rays
// cross it, nor a thing whose mirror image they are. spec 6 §2 (drop-offs).
// A mirror image has its thing as far above the ground as it lies below: where the camera looks past that place, there is none,
// and what lies below may be real. A mirror, or a near floor that a matcher gets wrong, is a patch with ground behind it or on both
// sides: so a gap narrower than that is no drop.
@group(0) @binding(0) var<uniform> drop_params: DropParams;
@group(0) @binding(1) var<storage, read> depth_m: array<f32>;
@group(0) @binding(2) var<storage, read> reliability: array<f32>;
@group(0) @binding(3) var<storage, read> rays: array<vec2<f32>>;
@group(0) @binding(4) var<storage, read> cell_hits: array<CellHits>;
@group(0) @binding(5) var<storage, read> drop_cells: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read> ground_now: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> drop_marks: array<atomic<u32>>;

// Whether rays come from the table (a lens with distortion), else from the pinhole.
override distorted: bool = true;

// Rays outside the lens model's field are stored this large.
const NO_RAY = 1.0e6;

// What the camera sees of a place: it does not look there, it looks past it, or something is there, or before it.
const NOT_SEEN = 0u;
const LOOKED_PAST = 1u;
const IN_THE_WAY = 2u;
const NEAR_M = 0.05;
// How near that place something is the thing that is mirrored: so much, and a share of its depth; pixels around that are asked.
const MIRROR_M = 0.1;
const MIRROR_PER_M = 0.08;
const MIRROR_STEP_PX = 2.0;
// Of the nine pixels so many must look past it: some are spikes.
const LEAST_PAST = 6u;
// How far around a patch of a mirror the ground must show: behind it, and beside it, in steps.
const PATCH_STEP_M = 0.05;
const PATCH_STEPS = 30u;
const PATCH_SIDE_STEPS = 8u;

fn ray_of(pixel: u32, u: u32, v: u32) -> vec2<f32> {
    if distorted {
        return rays[pixel];
    }
    return (vec2(f32(u), f32(v)) - drop_params.centre_px) / drop_params.focal_px;
}

// Whether the ground is seen in one of the cells around a place, in this frame or in several before.
fn is_ground_near(at: vec2<f32>) -> bool {
    var near = false;
    for (var k = 0u; k < 9u; k++) {
        let cell = cell_of(at + drop_params.resolution_m * (vec2(f32(k % 3u), f32(k / 3u)) - 1.0));
        if cell != NO_CELL {
            near = near || cell_hits[cell].top == FLOOR || is_known_ground(cell);
        }
    }
    return near;
}

// Whether something stands in one of the cells around a place.
fn stands_near(at: vec2<f32>) -> bool {
    var stands = false;
    for (var k = 0u; k < 9u; k++) {
        let cell = cell_of(at + drop_params.resolution_m * (vec2(f32(k % 3u), f32(k / 3u)) - 1.0));
        if cell != NO_CELL {
            stands = stands || cell_hits[cell].count > 0u;
        }
    }
    return stands;
}

// What the camera sees of the place as far above the ground as `place` lies below it.
fn seen_mirrored(place: vec3<f32>, height: f32) -> u32 {
    let off = place - 2.0 * height * ground_now[0].xyz - sensor_in_window();
    let at = drop_params.window_from_sensor_x.xyz * off.x
        + drop_params.window_from_sensor_y.xyz * off.y
        + drop_params.window_from_sensor_z.xyz * off.z;
    let ideal = at.xy / max(at.z, NEAR_M) * drop_params.focal_px + drop_params.centre_px;
    let size = vec2<f32>(f32(drop_params.width), f32(drop_params.measured / drop_params.width));
    // A lens with distortion moves it: it is not known where to.
    if distorted || at.z < NEAR_M {
        return NOT_SEEN;
    }
    var past = 0u;
    var in_the_way = false;
    for (var k = 0u; k < 9u; k++) {
        let pixel = floor(ideal + MIRROR_STEP_PX * (vec2(f32(k % 3u), f32(k / 3u)) - 1.0) + 0.5);
        if all(pixel >= vec2(0.0)) && all(pixel < size) {
            let depth = depth_m[u32(pixel.y) * drop_params.width + u32(pixel.x)];
            let is_there = depth != 0.0 && abs(depth) < at.z + MIRROR_M + MIRROR_PER_M * at.z;
            in_the_way = in_the_way || is_there;
            past += select(0u, 1u, depth > 0.0 && !is_there);
        }
    }
    return select(select(NOT_SEEN, LOOKED_PAST, past >= LEAST_PAST), IN_THE_WAY, in_the_way);
}

fn is_ground_at(at: vec2<f32>) -> bool {
    let cell = cell_of(at);
    return cell != NO_CELL && (cell_hits[min(cell, arrayLength(&cell_hits) - 1u)].top == FLOOR || is_known_ground(cell));
}

// Whether the ground goes on behind a place, as the camera looks, or close by on both sides of it.
fn is_in_ground(at: vec2<f32>) -> bool {
    let away = at - sensor_in_window().xy;
    let along = PATCH_STEP_M * away / max(length(away), 1.0e-6);
    let across = vec2(-along.y, along.x);
    var sides = vec3(false);
    for (var k = 1u; k < PATCH_STEPS + 1u; k++) {
        let beside = k <= PATCH_SIDE_STEPS;
        sides |= vec3(
            is_ground_at(at + f32(k) * along),
            beside && is_ground_at(at + f32(k) * across),
            beside && is_ground_at(at - f32(k) * across),
        );
    }
    return sides.x || (sides.y && sides.z);
}

@compute @workgroup_size(16, 4)
fn pixels(@builtin(global_invocation_id) id: vec3<u32>) {
    let u = id.x * drop_params.stride;
    let v = id.y * drop_params.stride;
    let pixel = v * drop_params.width + u;
    if id.x >= drop_params.columns || id.y >= drop_params.rows || pixel >= drop_params.measured || !is_ground_seen() {
        return;
    }
    let depth = depth_m[pixel];
    let ray = ray_of(pixel, u, v);
    if !(depth > 0.0 && ray.x < NO_RAY && reliability[pixel] > drop_params.tau) {
        return;
    }
    let place = in_window(vec3(ray * depth, depth));
    let height = height_of(place);
    for (var turn = 0u; turn < turns_if(is_deep(place, height)); turn++) {
        let crossing = crossing_of(place, height);
        let seen = seen_mirrored(place, height);
        // What lies far off is too uncertain to go by the ground alone.
        let is_far = length(place.xy - sensor_in_window().xy) > drop_params.range_m;
        var explained = seen == IN_THE_WAY || (seen == NOT_SEEN && is_far);
        for (var ask = 0u; ask < turns_if(!explained); ask++) {
            explained = is_ground_near(crossing) || stands_near(place.xy);
        }
        for (var ask = 0u; ask < turns_if(!explained); ask++) {
            explained = is_in_ground(crossing);
        }
        mark(crossing, place.xy, explained);
    }
}
