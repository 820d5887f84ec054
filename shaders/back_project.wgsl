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
    pad0: u32,
    pad1: u32,
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
@group(0) @binding(5) var<storage, read_write> counters: array<atomic<u32>>;

// Neighbours along a column mostly end in the same cell, so an invocation walks down a strip of one
// and pays for atomics only where the cell changes.
const STRIP = 16u;
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

@compute @workgroup_size(64)
fn back_project(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= back_project_params.width {
        return;
    }
    var valid = 0u;
    var low = 0u;
    var hits = 0u;
    let end = min((id.y + 1u) * STRIP, back_project_params.height);
    for (var v = id.y * STRIP; v < end; v++) {
        let pixel = v * back_project_params.width + id.x;
        let depth = depth_m[pixel];
        let weight = reliability[pixel];
        let trusted = weight > back_project_params.tau;
        valid += select(0u, 1u, depth > 0.0);
        low += select(1u, 0u, trusted);
        if !trusted || depth <= 0.0 {
            continue;
        }
        let ray = ray_of(pixel, id.x, v);
        if ray.x >= NO_RAY {
            continue;
        }
        let point = in_window(ray, depth);
        let above_min = point.z - back_project_params.height_min_m;
        let is_hit = above_min >= 0.0 && point.z <= back_project_params.height_max_m;
        let is_floor = abs(point.z) < back_project_params.height_min_m;
        let cell = cell_of(point);
        if cell == NO_CELL || !(is_hit || is_floor) {
            continue;
        }
        if cell != run_cell {
            flush();
            run_cell = cell;
        }
        if is_hit {
            hits++;
            run_hits.count++;
            run_hits.weight += u32(weight * back_project_params.weight_scale + 0.5);
            run_hits.top = max(run_hits.top, height_to_steps(above_min));
        } else {
            run_hits.floor = 1u;
        }
    }
    flush();
    atomicAdd(&counters[VALID_PIXELS], valid);
    atomicAdd(&counters[LOW_RELIABILITY_PIXELS], low);
    atomicAdd(&counters[HIT_PIXELS], hits);
}
