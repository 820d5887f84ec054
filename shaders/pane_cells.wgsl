// Puts a lidar's panes into the layer of panes: the cells that a pane's foot line crosses hold glass, where the pane is in the
// way. What this lidar kept of a cell goes, what it keeps now comes. spec 3 §7, spec 4 §1.
struct PaneCellsParams {
    window_from_lidar_x: vec4<f32>,
    window_from_lidar_y: vec4<f32>,
    window_from_lidar_z: vec4<f32>,
    side: u32,
    resolution_m: f32,
    band_low_m: f32,        // heights in which things are in the way, from the lidar's height
    band_high_m: f32,
    any_height: u32,        // 1: the ground is not known, and a pane counts whatever its height
    height_min_m: f32,      // the same from a ground that is seen
    height_max_m: f32,
    pad: u32,
}

struct PaneLayerParams {
    tick: u32,
    sensor: u32,            // + 1
    first: u32,             // of the lidar's panes in map_panes
    origin_slot_x: u32,
    origin_slot_y: u32,
}

@group(0) @binding(0) var<uniform> pane_cells_params: PaneCellsParams;
@group(0) @binding(1) var<storage, read> panes: Panes;
// The layer, the buffer `pane_cells`, whose name is the pass's.
//   x: id of the pane in bits 0-23, and sensor + 1; y: tick at which the pane was last found, 0: no pane
@group(0) @binding(2) var<storage, read_write> pane_records: array<vec2<u32>>;
@group(0) @binding(3) var<uniform> pane_layer_params: PaneLayerParams;
@group(0) @binding(4) var<storage, read> map_panes: array<Pane>;
// 0: height of a place of the window above the ground, as a scalar product with (place, 1); 1: x: above 0 where it was seen
// (spec 6 §2).
@group(0) @binding(5) var<storage, read> ground_now: array<vec4<f32>>;

// A pane that lies flatter than this is no wall: cosine of 45 degrees.
const UPRIGHT_COS = 0.7;

fn turned(v: vec3<f32>) -> vec3<f32> {
    return vec3(
        dot(pane_cells_params.window_from_lidar_x.xyz, v),
        dot(pane_cells_params.window_from_lidar_y.xyz, v),
        dot(pane_cells_params.window_from_lidar_z.xyz, v),
    );
}

// The lidar in the window.
fn shift() -> vec3<f32> {
    return vec3(
        pane_cells_params.window_from_lidar_x.w,
        pane_cells_params.window_from_lidar_y.w,
        pane_cells_params.window_from_lidar_z.w,
    );
}

// Whether the pane, `along` its level axis, reaches into the heights in which things are in the way.
fn in_way(pane: Pane, along: f32) -> bool {
    let upright = turned(cross(pane.normal.xyz, pane.level.xyz)).z * pane.extent.zw;
    let foot = shift() + turned(pane.normal.xyz) * pane.normal.w + turned(pane.level.xyz) * along;
    let on_ground = ground_now[1].x > 0.5;
    let foot_m = select(foot.z, dot(ground_now[0], vec4(foot, 1.0)), on_ground);
    let band_m = select(
        vec2(pane_cells_params.band_low_m, pane_cells_params.band_high_m),
        vec2(pane_cells_params.height_min_m, pane_cells_params.height_max_m),
        on_ground,
    );
    let low = foot_m + min(upright.x, upright.y) - MARGIN_M;
    let high = foot_m + max(upright.x, upright.y) + MARGIN_M;
    return (pane_cells_params.any_height == 1u && !on_ground) || (high >= band_m.x && low <= band_m.y);
}

fn crosses(pane: Pane, at: vec3<f32>) -> bool {
    let n = turned(pane.normal.xyz);
    if pane.id == 0u || abs(n.z) > UPRIGHT_COS {
        return false;
    }
    let off = dot(n, at - shift()) - pane.normal.w;
    let along = dot(turned(pane.level.xyz), at - shift());
    let half = 0.5 * pane_cells_params.resolution_m;
    let beside = along < pane.extent.x - half || along > pane.extent.y + half;
    return abs(off) <= half * (abs(n.x) + abs(n.y)) && !beside && in_way(pane, along);
}

// The `number` in the list of the pane that crosses the cell; KEPT_PANES: none.
fn keep_pane(x: u32, y: u32, number: u32) {
    let side = pane_cells_params.side;
    let slot = slot_of(x, y, pane_layer_params.origin_slot_x, pane_layer_params.origin_slot_y, side);
    let old = pane_records[slot];
    if number >= KEPT_PANES {
        if old.y != 0u && sensor_of(old.x) == pane_layer_params.sensor {
            pane_records[slot] = vec2(0u);
        }
        return;
    }
    let pane = map_panes[pane_layer_params.first + number];
    if old.y == 0u || sensor_of(old.x) == pane_layer_params.sensor || old.y <= pane.age {
        let by = (pane.id & 0xffffffu) | (pane_layer_params.sensor << SENSOR_SHIFT);
        pane_records[slot] = vec2(by, max(pane.age, 1u));
    }
}

@compute @workgroup_size(8, 8)
fn pane_cells(@builtin(global_invocation_id) id: vec3<u32>) {
    let side = pane_cells_params.side;
    if id.x >= side || id.y >= side {
        return;
    }
    let cell = vec2(f32(id.x), f32(id.y)) + 0.5;
    // z = 0 is the lidar's height.
    let at = vec3(cell * pane_cells_params.resolution_m, 0.0);
    var number = KEPT_PANES;
    for (var k = 0u; k < min(panes.slots, KEPT_PANES); k++) {
        if number == KEPT_PANES && crosses(panes.list[k], at) {
            number = k;
        }
    }
    keep_pane(id.x, id.y, number);
}
