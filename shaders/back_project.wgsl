// Puts depth pixels into the cells they end in: number, weights and highest point of the hits; floor points.
// spec 1 §3 (back-projection, hits). Weights are summed in fixed point, so the result does not depend on order.
struct BackProjectParams {
    window_from_camera_x: vec4<f32>,    // rows of the transform; z = 0 is the ground
    window_from_camera_y: vec4<f32>,
    window_from_camera_z: vec4<f32>,
    width: u32,
    height: u32,
    side: u32,
    resolution_m: f32,
    mark_range_m: f32,
    height_min_m: f32,
    height_max_m: f32,
    tau: f32,
    weight_scale: f32,                  // fixed-point one
    distorted: u32,                     // 1: rays come from the table, 0: from the pinhole
    focal_px: vec2<f32>,
    centre_px: vec2<f32>,
    groups: u32,                        // workgroups, and those a column of them has
    groups_y: u32,
}

struct AtomicCellHits {
    count: atomic<u32>,
    weight: atomic<u32>,
    top: atomic<u32>,
    floor: atomic<u32>,
}

@group(0) @binding(0) var<uniform> back_project_params: BackProjectParams;
@group(0) @binding(1) var<storage, read> depth_m: array<f32>;
@group(0) @binding(2) var<storage, read> reliability: array<f32>;
@group(0) @binding(3) var<storage, read> rays: array<vec2<f32>>;
@group(0) @binding(4) var<storage, read_write> cell_hits: array<AtomicCellHits>;
@group(0) @binding(5) var<storage, read_write> strip_counts: array<u32>;
@group(0) @binding(6) var<storage, read_write> far_strips: array<f32>;

// Neighbours along a column mostly end in the same cell, so an invocation walks down a strip of one
// and pays for atomics only where the cell changes. On its way it keeps the farthest trusted depth of
// every TILE pixels for see_through.
const STRIP = 2u * TILE;
const GROUP = 64u;
const NO_CELL = 0xffffffffu;

// Rays outside the lens model's field are stored this large.
const NO_RAY = 1.0e6;

var<private> run_cell: u32 = NO_CELL;
var<private> run_hits: CellHits;

fn flush() {
    if run_cell != NO_CELL {
        if run_hits.count > 0u {
            atomicAdd(&cell_hits[run_cell].count, run_hits.count);
            atomicAdd(&cell_hits[run_cell].weight, run_hits.weight);
            atomicMax(&cell_hits[run_cell].top, run_hits.top);
        }
        if run_hits.floor > 0u {
            atomicStore(&cell_hits[run_cell].floor, 1u);
        }
    }
    run_hits = CellHits(0u, 0u, 0u, 0u);
}

fn ray_of(pixel: u32, u: u32, v: u32) -> vec2<f32> {
    if back_project_params.distorted == 1u {
        return rays[pixel];
    }
    return (vec2(f32(u), f32(v)) - back_project_params.centre_px) / back_project_params.focal_px;
}

fn in_window(ray: vec2<f32>, depth: f32) -> vec3<f32> {
    let point = vec4(ray * depth, depth, 1.0);
    return vec3(
        dot(back_project_params.window_from_camera_x, point),
        dot(back_project_params.window_from_camera_y, point),
        dot(back_project_params.window_from_camera_z, point),
    );
}

fn cell_of(point: vec3<f32>) -> u32 {
    let camera = vec2(back_project_params.window_from_camera_x.w, back_project_params.window_from_camera_y.w);
    let side = back_project_params.side;
    let cell = floor(point.xy / back_project_params.resolution_m);
    let inside = all(cell >= vec2(0.0)) && all(cell < vec2(f32(side)));
    if !inside || distance(point.xy, camera) > back_project_params.mark_range_m {
        return NO_CELL;
    }
    return u32(cell.y) * side + u32(cell.x);
}

// Workgroups that run at the same time should not meet in the same cells: even ones take the left half
// of the image, odd ones the right half, each column by column.
fn strip_of(group: u32, lane: u32) -> vec2<u32> {
    let block = group / 2u + (group % 2u) * ((back_project_params.groups + 1u) / 2u);
    return vec2(block / back_project_params.groups_y * GROUP + lane, block % back_project_params.groups_y);
}

// Adds a trusted pixel to the run of its cell; whether it is a hit.
fn mark(point: vec3<f32>, weight: f32) -> bool {
    let above_min = point.z - back_project_params.height_min_m;
    let is_hit = above_min >= 0.0 && point.z <= back_project_params.height_max_m;
    let is_floor = abs(point.z) < back_project_params.height_min_m;
    let cell = cell_of(point);
    if cell == NO_CELL || !(is_hit || is_floor) {
        return false;
    }
    if cell != run_cell {
        flush();
        run_cell = cell;
    }
    if is_hit {
        run_hits.count++;
        run_hits.weight += u32(weight * back_project_params.weight_scale + 0.5);
        run_hits.top = max(run_hits.top, height_to_steps(above_min));
    } else {
        run_hits.floor = 1u;
    }
    return is_hit;
}

@compute @workgroup_size(GROUP)
fn back_project(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let width = back_project_params.width;
    let strip = strip_of(group.x, lane);
    if group.x >= back_project_params.groups || strip.x >= width {
        return;
    }
    var valid = 0u;
    var low = 0u;
    var hits = 0u;
    var far = 0.0;
    let end = min((strip.y + 1u) * STRIP, back_project_params.height);
    for (var v = strip.y * STRIP; v < end; v++) {
        let pixel = v * width + strip.x;
        let depth = depth_m[pixel];
        let weight = reliability[pixel];
        let trusted = weight > back_project_params.tau;
        valid += select(0u, 1u, depth > 0.0);
        low += select(1u, 0u, trusted);
        if trusted && depth > 0.0 {
            far = max(far, depth);
            let ray = ray_of(pixel, strip.x, v);
            if ray.x < NO_RAY && mark(in_window(ray, depth), weight) {
                hits++;
            }
        }
        if (v + 1u) % TILE == 0u || v + 1u == end {
            far_strips[v / TILE * width + strip.x] = far;
            far = 0.0;
        }
    }
    flush();
    strip_counts[strip.y * width + strip.x] = pack_counts(valid, low, hits);
}
