// Finds the pane that the way to each point meets first, and mirrors what lies before a pane through it, into the cells of
// the beams that would see it there. spec 3 §5 (per pane, step 1), §6. Four points an invocation, so that a pane is read
// once for the four.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> places: array<u32>;
@group(0) @binding(3) var<storage, read> elevation_rows: array<u32>;
@group(0) @binding(4) var<storage, read> panes: Panes;
@group(0) @binding(5) var<storage, read_write> mirrored: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> pane_counts: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> labels: array<u32>;

// Nearer to the plane than this a point is part of the pane's frame, metres.
const FRONT_M = 0.1;
const MM_PER_M = 1000.0;

struct Four {
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
}

struct FourCrossings {
    share: vec4<f32>,
    over: vec4<f32>,
    inside: vec4<bool>,
}

// Whether a point is in the slot of first returns; only its return type is read.
fn is_first(index: u32) -> bool {
    return (bitcast<u32>(points[2u * index + 1u].z) & 0xffu) != LAST;
}

fn along(n: vec3<f32>, p: Four) -> vec4<f32> {
    return n.x * p.x + n.y * p.y + n.z * p.z;
}

// As cross_pane.
fn cross_four(pane: Pane, p: Four) -> FourCrossings {
    let reach = along(pane.normal.xyz, p);
    let share = pane.normal.w / max(reach, vec4(1e-6));
    let u = along(pane.level.xyz, p) * share;
    let v = along(cross(pane.normal.xyz, pane.level.xyz), p) * share;
    let low = vec4(pane.extent.xz - MARGIN_M, pane.extent.yw + MARGIN_M);
    let inside = (reach > vec4(1e-6)) & (u >= low.xxxx) & (u <= low.zzzz) & (v >= low.yyyy) & (v <= low.wwww);
    return FourCrossings(share, reach - pane.normal.w, inside);
}

// Of a point that lies before the plane: its mirrored place, where the beam there meets this pane first.
fn put_image(pane: Pane, slot: u32, p: vec3<f32>) {
    let image = mirrored_in(pane, p);
    let row = elevation_rows[elevation_bin(image)];
    var seen = row < glass_params.rows;
    for (var turn = 0u; turn < turns_if(panes.slots > 1u); turn++) {
        seen = seen && first_met(image).slot == slot;
    }
    if seen {
        let place = column_of(image, glass_params.columns) * glass_params.rows + row;
        atomicMin(&mirrored[place], u32(length(image) * MM_PER_M));
    }
}

fn mirror_four(p: Four, usable: vec4<bool>) {
    for (var k = 0u; k < min(panes.slots, KEPT_PANES); k++) {
        let pane = panes.list[k];
        let before = pane.normal.w - along(pane.normal.xyz, p);
        let mirrors = usable & (before > vec4(FRONT_M)) & vec4(pane.id != 0u);
        let depths = select(vec4(0.0), before, mirrors);
        let depth_mm = u32(max(max(depths.x, depths.y), max(depths.z, depths.w)) * MM_PER_M);
        if depth_mm > atomicLoad(&pane_counts[k * PANE_COUNTS + ROOM_DEPTH]) {
            atomicMax(&pane_counts[k * PANE_COUNTS + ROOM_DEPTH], depth_mm);
        }
        let n = pane.normal.xyz;
        let image = Four(p.x + 2.0 * before * n.x, p.y + 2.0 * before * n.y, p.z + 2.0 * before * n.z);
        let seen = cross_four(pane, image).inside & mirrors;
        for (var turn = 0u; turn < select(0u, 4u, any(seen)); turn++) {
            for (var once = 0u; once < turns_if(seen[turn]); once++) {
                put_image(pane, k, vec3(p.x[turn], p.y[turn], p.z[turn]));
            }
        }
    }
}

@compute @workgroup_size(64)
fn mirror(@builtin(global_invocation_id) id: vec3<u32>) {
    let first = 4u * id.x;
    let count = glass_params.points;
    for (var turn = 0u; turn < turns_if(first < count); turn++) {
        let last = count - 1u;
        let at = min(vec4(first) + vec4(0u, 1u, 2u, 3u), vec4(last));
        let a = points[2u * at.x].xyz;
        let b = points[2u * at.y].xyz;
        let c = points[2u * at.z].xyz;
        let d = points[2u * at.w].xyz;
        let place = vec4(places[at.x], places[at.y], places[at.z], places[at.w]);
        // A point that is no number has no place, and meets nothing.
        let placed = place != vec4(NONE);
        let zero = vec4(0.0);
        let p = Four(
            select(zero, vec4(a.x, b.x, c.x, d.x), placed),
            select(zero, vec4(a.y, b.y, c.y, d.y), placed),
            select(zero, vec4(a.z, b.z, c.z, d.z), placed),
        );
        var slots = vec4(NONE);
        var least = vec4(3.0e38);
        for (var k = 0u; k < min(panes.slots, KEPT_PANES); k++) {
            let pane = panes.list[k];
            let crossing = cross_four(pane, p);
            let nearer = crossing.inside & (crossing.over > vec4(-glass_params.plane_tolerance_m))
                & (crossing.share < least) & vec4(pane.id != 0u);
            least = select(least, crossing.share, nearer);
            slots = select(slots, vec4(k), nearer);
        }
        let unmet = slots == vec4(NONE);
        let kinds = select(vec4(UNLABELLED), select(label_meeting(slots), vec4(INSIDE), unmet), placed);
        let first_slot = vec4(is_first(at.x), is_first(at.y), is_first(at.z), is_first(at.w));
        for (var k = 0u; k < min(4u, count - first); k++) {
            labels[first + k] = kinds[k];
        }
        mirror_four(p, placed & unmet & first_slot);
    }
}
