// Finds the pane that the way to each point meets first, and mirrors what lies before a pane through it, into the cells of
// the beams that would see it there. spec 3 §5 (per pane, step 1), §6. Four points an invocation, so that a pane is read
// once for the four. Most points meet no pane and are inside; the others are listed, in any order, for the passes that follow.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var placed: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(2) var row_texels: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(3) var pane_texels: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(4) var<storage, read_write> mirrored: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> pane_counts: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> classes: array<u32>;
@group(0) @binding(7) var<storage, read_write> met_points: array<atomic<u32>>;

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

// The pane that the way to a point meets first.
struct Met {
    slot: u32,      // NONE where it meets none
    over: f32,      // how far the point lies behind it, metres; within the tolerance it lies on it
}

fn first_met(p: vec3<f32>) -> Met {
    var met = Met(NONE, 0.0);
    var least = 3.0e38;
    let slots = pane_slots();
    for (var k = 0u; k < slots; k++) {
        let pane = pane_at(k);
        if pane.id != 0u {
            let crossing = cross_pane(pane, p, MARGIN_M);
            let reached = crossing.inside && crossing.over > -glass_params.plane_tolerance_m;
            if reached && crossing.share < least {
                least = crossing.share;
                met = Met(k, crossing.over);
            }
        }
    }
    return met;
}

// Mirrored places of points that lie before the plane, into the cells of the beams that meet this pane there first.
fn put_images(slot: u32, image: Four, wanted: vec4<bool>) {
    let level = sqrt(image.x * image.x + image.y * image.y);
    let range_mm = vec4<u32>(sqrt(level * level + image.z * image.z) * MM_PER_M);
    let bins = elevation_bins(image.z, level);
    let columns = columns_of(image.x, image.y, glass_params.columns);
    for (var k = 0u; k < 4u; k++) {
        for (var once = 0u; once < turns_if(wanted[k]); once++) {
            let row = row_of_bin(bins[k]);
            var seen = row < glass_params.rows;
            for (var turn = 0u; turn < turns_if(pane_slots() > 1u); turn++) {
                seen = seen && first_met(vec3(image.x[k], image.y[k], image.z[k])).slot == slot;
            }
            if seen {
                atomicMin(&mirrored[columns[k] * glass_params.rows + row], range_mm[k]);
            }
        }
    }
}

fn mirror_four(p: Four, has_place: vec4<bool>, usable: vec4<bool>) {
    let slots = pane_slots();
    for (var k = 0u; k < slots; k++) {
        let pane = pane_at(k);
        let before = pane.normal.w - along(pane.normal.xyz, p);
        let mirrors = usable & (before > vec4(FRONT_M)) & vec4(pane.id != 0u);
        let depths = select(vec4(0.0), before, has_place & vec4(pane.id != 0u));
        let depth_mm = u32(max(max(depths.x, depths.y), max(depths.z, depths.w)) * MM_PER_M);
        if depth_mm > atomicLoad(&pane_counts[k * PANE_COUNTS + ROOM_DEPTH]) {
            atomicMax(&pane_counts[k * PANE_COUNTS + ROOM_DEPTH], depth_mm);
        }
        let n = pane.normal.xyz;
        let image = Four(p.x + 2.0 * before * n.x, p.y + 2.0 * before * n.y, p.z + 2.0 * before * n.z);
        let seen = cross_four(pane, image).inside & mirrors;
        for (var once = 0u; once < turns_if(any(seen)); once++) {
            put_images(k, image, seen);
        }
    }
}

// Takes four points into the list of those that meet a pane.
fn list_met(first: u32, place: vec4<u32>, meets: vec4<bool>) {
    let one = select(vec4(0u), vec4(1u), meets);
    let begin = atomicAdd(&met_points[MET_COUNT], one.x + one.y + one.z + one.w);
    let at = vec4(0u, one.x, one.x + one.y, one.x + one.y + one.z) + begin;
    for (var k = 0u; k < 4u; k++) {
        if meets[k] {
            atomicStore(&met_points[met_at(at[k])], first + k);
            atomicStore(&met_points[met_at(at[k]) + 1u], place[k]);
        }
    }
}

fn store_classes(first: u32, kinds: vec4<u32>, given: vec4<bool>) {
    classes[first] = kinds.x;
    if given.y {
        classes[first + 1u] = kinds.y;
    }
    if given.z {
        classes[first + 2u] = kinds.z;
    }
    if given.w {
        classes[first + 3u] = kinds.w;
    }
}

@compute @workgroup_size(64)
fn mirror(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let count = glass_params.points;
    let turns = turns_from(4u * id.x, count, 4u * 64u * groups.x);
    for (var turn = 0u; turn < turns; turn++) {
        let first = 4u * (id.x + 64u * groups.x * turn);
        let last = count - 1u;
        let at = min(vec4(first) + vec4(0u, 1u, 2u, 3u), vec4(last));
        let a = textureLoad(placed, placed_texel(at.x), 0u);
        let b = textureLoad(placed, placed_texel(at.y), 0u);
        let c = textureLoad(placed, placed_texel(at.z), 0u);
        let d = textureLoad(placed, placed_texel(at.w), 0u);
        // A point without a place meets nothing.
        let number = vec4<u32>(vec4(a.w, b.w, c.w, d.w));
        let has_place = number != vec4(0u);
        let cell = max(number, vec4(1u)) - vec4(1u);
        let p = Four(vec4(a.x, b.x, c.x, d.x), vec4(a.y, b.y, c.y, d.y), vec4(a.z, b.z, c.z, d.z));
        var slots = vec4(NONE);
        var least = vec4(3.0e38);
        let most = pane_slots();
        for (var k = 0u; k < most; k++) {
            let pane = pane_at(k);
            let crossing = cross_four(pane, p);
            let nearer = crossing.inside & (crossing.over > vec4(-glass_params.plane_tolerance_m))
                & (crossing.share < least) & vec4(pane.id != 0u);
            least = select(least, crossing.share, nearer);
            slots = select(slots, vec4(k), nearer);
        }
        let unmet = slots == vec4(NONE);
        let kinds = select(vec4(UNLABELLED), select(label_meeting(slots), vec4(INSIDE), unmet), has_place);
        let given = vec4(first) + vec4(0u, 1u, 2u, 3u) < vec4(count);
        store_classes(first, kinds, given);
        let meets = !unmet & has_place & given;
        for (var once = 0u; once < turns_if(any(meets)); once++) {
            list_met(first, cell >> vec4(1u), meets);
        }
        mirror_four(p, has_place, has_place & unmet & ((cell & vec4(1u)) == vec4(0u)));
    }
}
