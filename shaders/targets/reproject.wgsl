// Measured depth of the other frames of the window, as the camera of one frame would have seen it: the nearest point that falls on
// each of its pixels. A row of the grid for each of the other frames.
// spec 1 §2 (frames are reprojected by pose before they are compared).
struct ReprojectParams {
    lens_a: vec4<f32>,          // k1, k2, p1, p2
    lens_b: vec4<f32>,          // k3, k4, k5, k6
    focal_px: vec2<f32>,
    centre_px: vec2<f32>,
    field_min: vec2<f32>,       // bounds of the rays that the lens model holds for
    field_max: vec2<f32>,
    width: u32,
    height: u32,
    slot_pixels: u32,           // from one slot of the window to the next
    views: u32,                 // other frames, at most 16
    view: array<vec4<u32>, 16>, // slot of each, unused
    target_from_view_x: array<vec4<f32>, 16>,
    target_from_view_y: array<vec4<f32>, 16>,
    target_from_view_z: array<vec4<f32>, 16>,
}

@group(0) @binding(0) var<uniform> reproject_params: ReprojectParams;
@group(0) @binding(1) var<storage, read> window_m: array<f32>;
@group(0) @binding(2) var<storage, read> rays: array<vec2<f32>>;
@group(0) @binding(3) var<storage, read_write> seen: array<atomic<u32>>;

@compute @workgroup_size(64)
fn reproject(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.x;
    let view = id.y;
    if pixel >= reproject_params.width * reproject_params.height || view >= reproject_params.views {
        return;
    }
    let depth = window_m[reproject_params.view[view].x * reproject_params.slot_pixels + pixel];
    let ray = rays[pixel];
    let point = vec4(ray * depth, depth, 1.0);
    let z = dot(reproject_params.target_from_view_z[view], point);
    if !(depth > 0.0 && z >= NEAREST_M && z <= FARTHEST_M) {
        return;
    }
    let ideal = vec2(
        dot(reproject_params.target_from_view_x[view], point),
        dot(reproject_params.target_from_view_y[view], point),
    ) / z;
    if !(all(ideal >= reproject_params.field_min) && all(ideal <= reproject_params.field_max)) {
        return;
    }
    let distorted = distort(ideal, reproject_params.lens_a, reproject_params.lens_b);
    let p = floor(distorted * reproject_params.focal_px + reproject_params.centre_px + 0.5);
    let size = vec2(f32(reproject_params.width), f32(reproject_params.height));
    if !(all(p >= vec2(0.0)) && all(p < size)) {
        return;
    }
    let at = u32(p.y) * reproject_params.width + u32(p.x);
    atomicMax(&seen[view * reproject_params.slot_pixels + at], nearness(z));
}
