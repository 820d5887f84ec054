// Puts panes into the map: the cells that a pane's foot line crosses hold glass, where the pane is in the way. spec 3 §7.
struct PaneCellsParams {
    window_from_lidar_x: vec4<f32>,
    window_from_lidar_y: vec4<f32>,
    window_from_lidar_z: vec4<f32>,
    side: u32,
    resolution_m: f32,
    band_low_m: f32,        // heights in which things are in the way, from the lidar's height
    band_high_m: f32,
    any_height: u32,        // 1: the ground is not known, and a pane counts whatever its height
    pad0: u32,
    pad1: u32,
    pad2: u32,
}

@group(0) @binding(0) var<uniform> pane_cells_params: PaneCellsParams;
@group(0) @binding(1) var<storage, read> panes: Panes;

// A pane that lies flatter than this is no wall: cosine of 45 degrees.
const UPRIGHT_COS = 0.7;

fn turned(v: vec3<f32>) -> vec3<f32> {
    return vec3(
        dot(pane_cells_params.window_from_lidar_x.xyz, v),
        dot(pane_cells_params.window_from_lidar_y.xyz, v),
        dot(pane_cells_params.window_from_lidar_z.xyz, v),
    );
}

// Whether the pane, `along` its level axis, reaches into the heights in which things are in the way.
fn in_way(pane: Pane, along: f32) -> bool {
    let upright = turned(cross(pane.normal.xyz, pane.level.xyz)).z * pane.extent.zw;
    let foot = pane_cells_params.window_from_lidar_z.w
        + turned(pane.normal.xyz).z * pane.normal.w
        + turned(pane.level.xyz).z * along;
    let low = foot + min(upright.x, upright.y) - MARGIN_M;
    let high = foot + max(upright.x, upright.y) + MARGIN_M;
    return pane_cells_params.any_height == 1u
        || (high >= pane_cells_params.band_low_m && low <= pane_cells_params.band_high_m);
}

fn crosses(pane: Pane, at: vec3<f32>) -> bool {
    let shift = vec3(
        pane_cells_params.window_from_lidar_x.w,
        pane_cells_params.window_from_lidar_y.w,
        pane_cells_params.window_from_lidar_z.w,
    );
    let n = turned(pane.normal.xyz);
    if pane.id == 0u || abs(n.z) > UPRIGHT_COS {
        return false;
    }
    let off = dot(n, at - shift) - pane.normal.w;
    let along = dot(turned(pane.level.xyz), at - shift);
    let half = 0.5 * pane_cells_params.resolution_m;
    let beside = along < pane.extent.x - half || along > pane.extent.y + half;
    return abs(off) <= half * (abs(n.x) + abs(n.y)) && !beside && in_way(pane, along);
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
