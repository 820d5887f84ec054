// Lets the pixels of a depth image vote for the cells of the ground that their rays meet: the ground is seen there, or they go on
// to what lies deeper. spec 6 §2 (drop-offs).
// A mirror image has its thing as far above the ground as it lies below: where the camera looks past that place, there is none,
// and what lies below is real.
@group(0) @binding(0) var<uniform> drop_params: DropParams;
@group(0) @binding(1) var<storage, read> depth_m: array<f32>;
@group(0) @binding(2) var<storage, read> reliability: array<f32>;
@group(0) @binding(3) var<storage, read> rays: array<vec2<f32>>;
@group(0) @binding(6) var<storage, read> ground_now: array<vec4<f32>>;
@group(0) @binding(7) var<storage, read_write> drop_marks: array<atomic<u32>>;

// Whether rays come from the table (a lens with distortion), else from the pinhole.
override distorted: bool = true;

// Rays outside the lens model's field are stored this large.
const NO_RAY = 1.0e6;

const NEAR_M = 0.05;
// How near the mirrored place something is the thing that is mirrored: so much, and a share of its depth; pixels around that are
// asked.
const MIRROR_M = 0.1;
const MIRROR_PER_M = 0.08;
const MIRROR_STEP_PX = 2.0;
// Of the nine pixels so many must look past it: some are spikes.
const LEAST_PAST = 6u;
// A pixel whose neighbours lie elsewhere is a spike: how far beside it they are asked, as a part of the image's width; by how much
// their depths may differ; how many of the four must not.
const BESIDE_PARTS = 140u;
const BESIDE_M = 0.03;
const BESIDE_PER_M = 0.06;
const LEAST_BESIDE = 3u;

fn ray_of(pixel: u32, u: u32, v: u32) -> vec2<f32> {
    if distorted {
        return rays[pixel];
    }
    return (vec2(f32(u), f32(v)) - drop_params.centre_px) / drop_params.focal_px;
}

fn size_px() -> vec2<f32> {
    return vec2(f32(drop_params.width), f32(drop_params.measured / max(drop_params.width, 1u)));
}

// Whether the neighbours of a pixel lie near it.
fn is_borne_out(u: u32, v: u32, depth: f32) -> bool {
    let step = f32(max(drop_params.width / BESIDE_PARTS, 1u));
    let size = size_px();
    var near = 0u;
    for (var k = 0u; k < 4u; k++) {
        let off = select(-step, step, (k & 1u) == 1u);
        let at = vec2(f32(u), f32(v)) + select(vec2(0.0, off), vec2(off, 0.0), k < 2u);
        if all(at >= vec2(0.0)) && all(at < size) {
            let pixel = u32(at.y) * drop_params.width + u32(at.x);
            let beside = depth_m[pixel];
            let is_near = beside > 0.0 && abs(beside - depth) < BESIDE_M + BESIDE_PER_M * depth;
            near += select(0u, 1u, is_near && reliability[pixel] > drop_params.tau);
        }
    }
    return near >= LEAST_BESIDE;
}

// What the camera sees of the place as far above the ground as `place` lies below it.
fn seen_mirrored(place: vec3<f32>, height: f32) -> u32 {
    let off = mirrored(place, height);
    let at = drop_params.window_from_sensor_x.xyz * off.x
        + drop_params.window_from_sensor_y.xyz * off.y
        + drop_params.window_from_sensor_z.xyz * off.z;
    if at.z < NEAR_M {
        return NOT_SEEN;
    }
    var ray = at.xy / at.z;
    if distorted {
        ray = distort(ray, drop_params.lens_a, drop_params.lens_b);
    }
    let middle = ray * drop_params.focal_px + drop_params.centre_px;
    let size = size_px();
    var past = 0u;
    var in_the_way = false;
    for (var k = 0u; k < 9u; k++) {
        let pixel = floor(middle + MIRROR_STEP_PX * (vec2(f32(k % 3u), f32(k / 3u)) - 1.0) + 0.5);
        if all(pixel >= vec2(0.0)) && all(pixel < size) {
            let depth = depth_m[u32(pixel.y) * drop_params.width + u32(pixel.x)];
            let is_there = depth != 0.0 && abs(depth) < at.z + MIRROR_M + MIRROR_PER_M * at.z;
            in_the_way = in_the_way || is_there;
            past += select(0u, 1u, depth > 0.0 && !is_there);
        }
    }
    return select(select(NOT_SEEN, LOOKED_PAST, past >= LEAST_PAST), IN_THE_WAY, in_the_way);
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
    let crossing = crossing_of(place);
    var kind = crossing.does;
    let meets = kind != ROUGH;
    for (var ask = 0u; ask < turns_if(kind == OPEN); ask++) {
        kind = vote_by(seen_mirrored(place, crossing.height));
        kind = select(ROUGH, kind, kind == MIRRORED || is_borne_out(u, v, depth));
    }
    if meets {
        vote(crossing, kind);
    }
}
