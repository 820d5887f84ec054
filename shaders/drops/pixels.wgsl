// Finds pixels of a depth image that lie below the ground where nothing explains it: neither the ground, seen where their rays
// cross it, nor a thing that stands where they seem to lie, whose mirror image they are. spec 6 §2 (drop-offs).
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

fn ray_of(pixel: u32) -> vec2<f32> {
    if distorted {
        return rays[pixel];
    }
    let at = vec2(f32(pixel % drop_params.width), f32(pixel / drop_params.width));
    return (at - drop_params.centre_px) / drop_params.focal_px;
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

@compute @workgroup_size(64)
fn pixels(@builtin(global_invocation_id) id: vec3<u32>) {
    let u = (id.x % max(drop_params.columns, 1u)) * drop_params.stride;
    let v = (id.x / max(drop_params.columns, 1u)) * drop_params.stride;
    let pixel = v * drop_params.width + u;
    if id.x >= drop_params.columns * drop_params.rows || pixel >= drop_params.measured || !is_ground_seen() {
        return;
    }
    let depth = depth_m[pixel];
    let ray = ray_of(pixel);
    if !(depth > 0.0 && ray.x < NO_RAY && reliability[pixel] > drop_params.tau) {
        return;
    }
    let place = in_window(vec3(ray * depth, depth));
    let height = height_of(place);
    if !is_deep(place, height) {
        return;
    }
    let crossing = crossing_of(place, height);
    mark(crossing, place.xy, is_ground_near(crossing) || stands_near(place.xy));
}
