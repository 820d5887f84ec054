// Puts depth pixels into the cells they end in: number, weights and highest point of the hits; floor points.
// spec 1 §3 (back-projection, hits). Weights are summed in fixed point, so the result does not depend on order.
// A depth below 0 is that of a pane that the ray meets first (camera/pane_clip): it marks nothing, and clears up to there.
struct BackProjectParams {
    window_from_camera_x: vec4<f32>,    // rows of the transform; heights count from the ground (ground_now)
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
    pad: u32,
    focal_px: vec2<f32>,
    centre_px: vec2<f32>,
    groups: u32,                        // workgroups, and those a column of them has
    groups_y: u32,
}

struct AtomicCellHits {
    count: atomic<u32>,
    weight: atomic<u32>,
    top: atomic<u32>,
    low: atomic<u32>,
}

@group(0) @binding(0) var<uniform> back_project_params: BackProjectParams;
@group(0) @binding(1) var<storage, read> depth_m: array<f32>;
@group(0) @binding(2) var<storage, read> reliability: array<f32>;
@group(0) @binding(3) var<storage, read> rays: array<vec2<f32>>;
@group(0) @binding(4) var<storage, read_write> cell_hits: array<AtomicCellHits>;
@group(0) @binding(5) var<storage, read_write> strip_counts: array<u32>;
// 0: height of a place of the window above the ground, as a scalar product with (place, 1) (spec 6 §2).
@group(0) @binding(7) var<storage, read> ground_now: array<vec4<f32>>;

// Neighbours along a column mostly end in the same cell, so an invocation walks down a strip of one, four
// pixels at a time, and pays for atomics only where the cell changes. On its way it keeps the farthest
// trusted depth of every TILE pixels, where see_through asks for it (lib/far).
const STRIP = 2u * TILE;
const GROUP = 64u;
const NO_CELL = 0xffffffffu;

// Whether rays come from the table (a lens with distortion), else from the pinhole.
override distorted: bool = true;

// Whether the lowest hits are kept, and the weights even where they count fully: a lidar may refute them.
override lowest: bool = false;

// Rays outside the lens model's field are stored this large.
const NO_RAY = 1.0e6;

// Four pixels down a column: the cell each ends in (NO_CELL: none), its weight and its height in steps.
struct Four {
    cells: vec4<u32>,
    weights: vec4<u32>,
    tops: vec4<u32>,
}

// What one strip has put into one cell so far.
struct Run {
    cell: u32,
    count: u32,
    weight: u32,
    top: u32,
    low: u32,       // steps with all bits inverted
}

fn flush(run: Run) {
    if run.cell == NO_CELL {
        return;
    }
    atomicMax(&cell_hits[run.cell].top, run.top);
    if run.count > 0u {
        atomicAdd(&cell_hits[run.cell].count, run.count);
    }
    if weighted && (!gated || lowest) && run.weight > 0u {
        atomicAdd(&cell_hits[run.cell].weight, run.weight);
    }
    if lowest && run.low > 0u {
        atomicMax(&cell_hits[run.cell].low, run.low);
    }
}

// The lowest hit so far, inverted as it is kept.
fn lower(low: u32, tops: vec4<u32>) -> u32 {
    if !lowest {
        return 0u;
    }
    let lows = select(vec4(0u), ~tops, tops > vec4(FLOOR));
    return max(max(max(low, lows.x), max(lows.y, lows.z)), lows.w);
}

fn absorb(run: Run, four: Four, mine: vec4<bool>) -> Run {
    let tops = select(vec4(0u), four.tops, mine);
    let hits = select(vec4(0u), vec4(1u), tops > vec4(FLOOR));
    let weights = four.weights * hits;
    return Run(
        run.cell,
        run.count + hits.x + hits.y + hits.z + hits.w,
        run.weight + weights.x + weights.y + weights.z + weights.w,
        max(max(max(run.top, tops.x), max(tops.y, tops.z)), tops.w),
        lower(run.low, tops),
    );
}

// Adds four pixels to the run, closing it and opening another as often as the cell changes.
fn extend(before: Run, four: Four) -> Run {
    var run = before;
    var open = four.cells != vec4(NO_CELL);
    loop {
        let mine = open & (four.cells == vec4(run.cell));
        run = absorb(run, four, mine);
        open = open & !mine;
        if !any(open) {
            break;
        }
        flush(run);
        let rest = select(vec4(NO_CELL), four.cells, open);
        run = Run(min(min(rest.x, rest.y), min(rest.z, rest.w)), 0u, 0u, 0u, 0u);
    }
    return run;
}

fn ray_of(pixel: u32, u: u32, v: u32) -> vec2<f32> {
    if distorted {
        return rays[pixel];
    }
    return (vec2(f32(u), f32(v)) - back_project_params.centre_px) / back_project_params.focal_px;
}

fn weight_of(pixel: u32, depth: f32) -> f32 {
    if weighted {
        return reliability[pixel];
    }
    return select(0.0, 1.0, depth != 0.0);
}

// The row that gives the height of a point of the camera above the ground.
fn height_row() -> vec4<f32> {
    let up = ground_now[0];
    return up.x * back_project_params.window_from_camera_x
        + up.y * back_project_params.window_from_camera_y
        + up.z * back_project_params.window_from_camera_z
        + vec4(0.0, 0.0, 0.0, up.w);
}

// x and y in the window, and the height above the ground.
fn in_window(ray: vec2<f32>, depth: f32, height: vec4<f32>) -> vec3<f32> {
    let point = vec4(ray * depth, depth, 1.0);
    return vec3(
        dot(back_project_params.window_from_camera_x, point),
        dot(back_project_params.window_from_camera_y, point),
        dot(height, point),
    );
}

fn cell_of(point: vec3<f32>) -> u32 {
    let camera = vec2(back_project_params.window_from_camera_x.w, back_project_params.window_from_camera_y.w);
    let side = back_project_params.side;
    let cell = floor(point.xy / back_project_params.resolution_m);
    let inside = all(cell >= vec2(0.0)) && all(cell < vec2(f32(side)));
    let offset = point.xy - camera;
    if !inside || dot(offset, offset) > back_project_params.mark_range_m * back_project_params.mark_range_m {
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

// What one pixel gives.
struct Look {
    cell: u32,          // NO_CELL: it marks nothing
    weight: u32,
    top: u32,
    far: f32,           // its depth where it is trusted
    counts: u32,        // packed: valid, low reliability, hit
}

fn look(u: u32, v: u32, height: vec4<f32>) -> Look {
    let inside = v < back_project_params.height;
    let pixel = min(v, back_project_params.height - 1u) * back_project_params.width + u;
    let depth = depth_m[pixel];
    let weight = weight_of(pixel, depth);
    let ray = ray_of(pixel, u, v);
    let trusted = weight > back_project_params.tau;
    let usable = inside && trusted && depth > 0.0;
    let looks = inside && trusted && depth != 0.0;
    let point = in_window(ray, depth, height);
    let above_min = point.z - back_project_params.height_min_m;
    let is_hit = above_min >= 0.0 && point.z <= back_project_params.height_max_m;
    let is_floor = abs(point.z) < back_project_params.height_min_m;
    let cell = cell_of(point);
    let marks = usable && ray.x < NO_RAY && (is_hit || is_floor) && cell != NO_CELL;
    let valid = select(0u, 1u, depth != 0.0);
    return Look(
        select(NO_CELL, cell, marks),
        u32(weight * back_project_params.weight_scale + 0.5),
        select(FLOOR, height_to_steps(above_min), is_hit),
        select(0.0, abs(depth), looks),
        select(0u, pack_counts(valid, select(1u, 0u, trusted), select(0u, 1u, marks && is_hit)), inside),
    );
}

@compute @workgroup_size(GROUP)
fn back_project(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let width = back_project_params.width;
    let height = back_project_params.height;
    let strip = strip_of(group.x, lane);
    if group.x >= back_project_params.groups || strip.x >= width {
        return;
    }
    let up = height_row();
    var counts = 0u;
    var run = Run(NO_CELL, 0u, 0u, 0u, 0u);
    for (var tile = 2u * strip.y; tile < 2u * strip.y + 2u && tile * TILE < height; tile++) {
        var far = 0.0;
        for (var v = tile * TILE; v < (tile + 1u) * TILE; v += 4u) {
            let a = look(strip.x, v, up);
            let b = look(strip.x, v + 1u, up);
            let c = look(strip.x, v + 2u, up);
            let d = look(strip.x, v + 3u, up);
            far = max(far, max(max(a.far, b.far), max(c.far, d.far)));
            counts += a.counts + b.counts + c.counts + d.counts;
            let cells = vec4(a.cell, b.cell, c.cell, d.cell);
            let weights = vec4(a.weight, b.weight, c.weight, d.weight);
            run = extend(run, Four(cells, weights, vec4(a.top, b.top, c.top, d.top)));
        }
        keep_far(tile * width + strip.x, far);
    }
    flush(run);
    strip_counts[strip.y * width + strip.x] = counts;
}
