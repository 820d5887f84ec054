// Keeps a lidar's panes for the other sensors: in the map's axes, from an origin near the first pose.
// spec 4 §1 (panes). In place of a pane's age in scans stands the tick at which it was last found.
struct SharePanesParams {
    local_from_lidar_x: vec4<f32>,
    local_from_lidar_y: vec4<f32>,
    local_from_lidar_z: vec4<f32>,
    first: u32,             // of the lidar's panes
    tick: u32,
    pad0: u32,
    pad1: u32,
}

@group(0) @binding(0) var<uniform> share_panes_params: SharePanesParams;
@group(0) @binding(1) var<storage, read> panes: Panes;
@group(0) @binding(2) var<storage, read_write> map_panes: array<Pane>;

fn turned(v: vec3<f32>) -> vec3<f32> {
    return vec3(
        dot(share_panes_params.local_from_lidar_x.xyz, v),
        dot(share_panes_params.local_from_lidar_y.xyz, v),
        dot(share_panes_params.local_from_lidar_z.xyz, v),
    );
}

fn moved(pane: Pane) -> Pane {
    let shift = vec3(
        share_panes_params.local_from_lidar_x.w,
        share_panes_params.local_from_lidar_y.w,
        share_panes_params.local_from_lidar_z.w,
    );
    var out = pane;
    let n = turned(pane.normal.xyz);
    let u = turned(pane.level.xyz);
    out.normal = vec4(n, pane.normal.w + dot(n, shift));
    out.level = vec4(u, pane.level.w);
    out.extent = pane.extent + vec4(vec2(dot(u, shift)), vec2(dot(cross(n, u), shift)));
    return out;
}

@compute @workgroup_size(16)
fn share_panes(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= KEPT_PANES {
        return;
    }
    let at = share_panes_params.first + id.x;
    let old = map_panes[at];
    var pane = panes.list[id.x];
    if id.x >= panes.slots || pane.id == 0u {
        pane.id = 0u;
        pane.age = 0u;
        map_panes[at] = pane;
        return;
    }
    pane = moved(pane);
    let found = old.id != pane.id || old.hits != pane.hits;
    pane.age = select(old.age, share_panes_params.tick, found);
    map_panes[at] = pane;
}
