// Finds the cells that trusted rays cross inside the height band before they end: one gather per cell.
// spec 1 §3 (seen through), §9 (looks through). Needs one of lib/looking.
//
// The vertical through a cell's centre is a line in the image. A pixel on that line looks through the
// cell at a known height; it sees through it when its depth lies behind the cell's far edge. The height
// band lies above the ground, so that no part of a ray beyond its crossing of the ground clears anything.
// A depth below 0 is that of a pane that the ray meets before it ends: it clears up to there (spec 4 §1).
struct SeeThroughGatherParams {
    camera_from_window_x: vec4<f32>,    // rows of the transform
    camera_from_window_y: vec4<f32>,
    camera_from_window_z: vec4<f32>,
    lens_a: vec4<f32>,                  // k1, k2, p1, p2
    lens_b: vec4<f32>,                  // k3, k4, k5, k6
    focal_px: vec2<f32>,
    centre_px: vec2<f32>,
    field_min: vec2<f32>,               // bounds of the ideal rays of all pixels
    field_max: vec2<f32>,
    camera_xy_m: vec2<f32>,
    width: u32,
    height: u32,
    side: u32,
    origin_slot_x: u32,
    origin_slot_y: u32,
    min_hits: u32,
    resolution_m: f32,
    mark_range_m: f32,
    height_min_m: f32,
    height_max_m: f32,
    tau: f32,
    tiles_x: u32,
    first_x: u32,       // the view's cells, the others are left as they are
    first_y: u32,
}

@group(0) @binding(0) var<uniform> see_through_gather_params: SeeThroughGatherParams;
@group(0) @binding(1) var<storage, read> depth_m: array<f32>;
@group(0) @binding(2) var<storage, read> reliability: array<f32>;
@group(0) @binding(3) var<storage, read> cells: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read> cell_hits: array<CellHits>;
@group(0) @binding(6) var<storage, read_write> seen_through: array<u32>;
// 0: height of a place of the window above the ground, as a scalar product with (place, 1) (spec 6 §2).
@group(0) @binding(7) var<storage, read> ground_now: array<vec4<f32>>;

const NEAR_M = 0.05;
const MAX_SAMPLES = 4096.0;

const NO_PIXEL = 0xffffffffu;

// A stretch of the vertical, as seen by the camera: ideal rays and inverse depths of its ends.
struct Stretch {
    from_ray: vec2<f32>,
    to_ray: vec2<f32>,
    inverse_z: vec2<f32>,
    samples: f32,       // 0: not in view
}

fn to_camera(point: vec3<f32>) -> vec3<f32> {
    let p = vec4(point, 1.0);
    return vec3(
        dot(see_through_gather_params.camera_from_window_x, p),
        dot(see_through_gather_params.camera_from_window_y, p),
        dot(see_through_gather_params.camera_from_window_z, p),
    );
}

// Where on [s.x, s.y] the coordinate from + s * step lies in [low, high].
fn clip(s: vec2<f32>, origin: f32, step: f32, low: f32, high: f32) -> vec2<f32> {
    if abs(step) < 1.0e-9 {
        return select(vec2(1.0, 0.0), s, origin >= low && origin <= high);
    }
    let a = (low - origin) / step;
    let b = (high - origin) / step;
    return vec2(max(s.x, min(a, b)), min(s.y, max(a, b)));
}

// The vertical through a cell's centre between two heights above the ground.
fn stretch_of(centre: vec2<f32>, low_m: f32, high_m: f32) -> Stretch {
    let up = ground_now[0];
    let z = (vec2(low_m, high_m) - up.w - dot(up.xy, centre)) / up.z;
    var a = to_camera(vec3(centre, z.x));
    var b = to_camera(vec3(centre, z.y));
    var none: Stretch;
    none.samples = 0.0;
    let near = clip(vec2(0.0, 1.0), a.z, b.z - a.z, NEAR_M, 1.0e9);
    if near.x > near.y {
        return none;
    }
    let along = b - a;
    b = a + along * near.y;
    a = a + along * near.x;
    let from_ray = a.xy / a.z;
    let step = b.xy / b.z - from_ray;
    var s = vec2(0.0, 1.0);
    s = clip(s, from_ray.x, step.x, see_through_gather_params.field_min.x, see_through_gather_params.field_max.x);
    s = clip(s, from_ray.y, step.y, see_through_gather_params.field_min.y, see_through_gather_params.field_max.y);
    if s.x > s.y {
        return none;
    }
    let inverse = vec2(1.0 / a.z, 1.0 / b.z);
    let pixels = abs(step * (s.y - s.x)) * see_through_gather_params.focal_px;
    return Stretch(
        from_ray + step * s.x,
        from_ray + step * s.y,
        vec2(mix(inverse.x, inverse.y, s.x), mix(inverse.x, inverse.y, s.y)),
        min(ceil(max(pixels.x, pixels.y)) + 1.0, MAX_SAMPLES),
    );
}

// The pixel that looks along an ideal ray; it may lie outside the image.
fn pixel_of(ray: vec2<f32>) -> vec2<f32> {
    let distorted = distort(ray, see_through_gather_params.lens_a, see_through_gather_params.lens_b);
    return floor(distorted * see_through_gather_params.focal_px + see_through_gather_params.centre_px + 0.5);
}

// The number of the pixel on the stretch at s; NO_PIXEL outside of the image.
fn pixel_on(stretch: Stretch, s: f32) -> u32 {
    let size = vec2(f32(see_through_gather_params.width), f32(see_through_gather_params.height));
    let p = pixel_of(mix(stretch.from_ray, stretch.to_ray, s));
    if any(p < vec2(0.0)) || any(p >= size) {
        return NO_PIXEL;
    }
    return u32(p.y) * see_through_gather_params.width + u32(p.x);
}

// Whether the pixel, on the stretch at s, is trusted and looks past `behind` times its own depth there.
fn ray_passes(pixel: u32, stretch: Stretch, s: f32, behind: f32) -> bool {
    if pixel == NO_PIXEL {
        return false;
    }
    // A reliability that is NaN is none.
    if weighted && !(reliability[pixel] > see_through_gather_params.tau) {
        return false;
    }
    return abs(depth_m[pixel]) * mix(stretch.inverse_z.x, stretch.inverse_z.y, s) > behind;
}

// A cell within the mark range.
struct Place {
    x: u32,
    y: u32,
    cell: u32,
    slot: u32,
    centre: vec2<f32>,
    behind: f32,        // a depth lies behind the cell that is more than so many times the centre's own; 0: the camera stands in the cell
}

@compute @workgroup_size(8, 8)
fn gather(@builtin(global_invocation_id) invocation: vec3<u32>) {
    let side = see_through_gather_params.side;
    let id = invocation.xy + vec2(see_through_gather_params.first_x, see_through_gather_params.first_y);
    if id.x >= side || id.y >= side {
        return;
    }
    let cell = id.y * side + id.x;
    let centre = (vec2<f32>(id) + 0.5) * see_through_gather_params.resolution_m;
    let offset = centre - see_through_gather_params.camera_xy_m;
    let range = length(offset);
    if range > see_through_gather_params.mark_range_m {
        return;
    }
    // Distance from the centre to the cell's far edge along the ray.
    let reach = 0.5 * see_through_gather_params.resolution_m * range / max(max(abs(offset.x), abs(offset.y)), 1.0e-6);
    let behind = select(0.0, 1.0 + reach / range, range > reach);
    let slot = slot_of(id.x, id.y, see_through_gather_params.origin_slot_x, see_through_gather_params.origin_slot_y, side);
    let word = looked_through(Place(id.x, id.y, cell, slot, centre, behind));
    if word != 0u {
        seen_through[cell] = word;
    }
}
