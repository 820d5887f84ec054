// Panes: plane n . x = d with d > 0, axes u (level) and v = n x u, extents of u and v (spec 3 §4, §6).
const SCAN_PANES = 4u;
const SCAN_MIRRORS = 2u;
const KEPT_PANES = 16u;

struct Pane {
    normal: vec4<f32>,  // n; w: d, metres
    level: vec4<f32>,   // u; w: intensity above which a return on the plane is frame and no glass, 0: not known, MIRROR_LEVEL: a mirror
    extent: vec4<f32>,  // least and largest u, least and largest v, metres
    id: u32,            // counts panes from 1; 0: none here
    hits: u32,          // scans that found it
    misses: u32,        // scans whose beams went through where it should show, since it was last found
    age: u32,           // scans since it was first found
}

// The panes by which a scan is labelled.
struct Panes {
    slots: u32,         // that may hold one
    pad0: u32,
    pad1: u32,
    pad2: u32,
    list: array<Pane, KEPT_PANES>,
}

// In place of an intensity: the pane is a mirror, and nothing shows through it.
const MIRROR_LEVEL = -1.0;

fn is_mirror(pane: Pane) -> bool {
    return pane.level.w < 0.0;
}

// A pane's edge is known no better than this, metres.
const MARGIN_M = 0.3;

struct Crossing {
    share: f32,     // of the way to the point at which the plane is met
    over: f32,      // how far the point lies behind the plane, metres
    inside: bool,   // whether the plane is met within the pane
}

fn cross_pane(pane: Pane, p: vec3<f32>, margin_m: f32) -> Crossing {
    let along = dot(pane.normal.xyz, p);
    if along <= 1e-6 || pane.id == 0u {
        return Crossing(0.0, -1.0, false);
    }
    let share = pane.normal.w / along;
    let at = p * share;
    let u = dot(at, pane.level.xyz);
    let v = dot(at, cross(pane.normal.xyz, pane.level.xyz));
    let inside = u >= pane.extent.x - margin_m && u <= pane.extent.y + margin_m
        && v >= pane.extent.z - margin_m && v <= pane.extent.w + margin_m;
    return Crossing(share, along - pane.normal.w, inside);
}

fn mirrored_in(pane: Pane, p: vec3<f32>) -> vec3<f32> {
    return p - 2.0 * (dot(pane.normal.xyz, p) - pane.normal.w) * pane.normal.xyz;
}

// u of a plane: level where the plane stands, along x where it lies.
fn level_axis(n: vec3<f32>) -> vec3<f32> {
    let level = cross(vec3(0.0, 0.0, 1.0), n);
    return normalize(select(cross(vec3(1.0, 0.0, 0.0), n), level, dot(level, level) > 0.01));
}
