// Carries panes from scan to scan in the map frame, with coordinates from an origin near the first pose: finds the kept pane of each one of this scan, refines it, keeps new
// ones, lets go of those that beams have gone through, and gives the panes by which this scan is labelled. spec 3 §7.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var<storage, read> found: Found;
@group(0) @binding(2) var<storage, read> scan_panes: array<Pane>;
@group(0) @binding(3) var<storage, read> loaded_panes: array<Pane>;
@group(0) @binding(4) var<storage, read_write> kept: Kept;
@group(0) @binding(5) var<storage, read_write> pane_counts: array<u32>;
@group(0) @binding(6) var<storage, read_write> panes: Panes;
@group(0) @binding(7) var<storage, read_write> met_points: array<u32>;
@group(0) @binding(8) var pane_texels: texture_storage_2d_array<rgba32float, write>;
@group(0) @binding(9) var<storage, read> scan_ends: array<vec4<f32>>;
@group(0) @binding(10) var<storage, read_write> kept_ends: array<vec4<f32>>;

struct Kept {
    last_id: u32,
    pad0: u32,
    pad1: u32,
    pad2: u32,
    panes: array<Pane, KEPT_PANES>,
}

// The same pane: normals within 8 degrees, centre this near to the plane, within this of the extents.
const SAME_COS = 0.99;
const SAME_M = 0.3;
const SAME_EDGE_M = 1.0;
// A mean over more scans than this would follow a drifting map too slowly.
const MOST_HITS = 50u;
// Head-on beams that must have met a pane's place before its absence counts, and the share of them that must still end on
// it.
const LEAST_HEAD_ON = 30u;
const LEAST_SHOWING = 0.1;
// Of what lies behind a mirror, the share whose mirrored place is measured or seen through and that must be measured.
const LEAST_MIRRORED = 0.8;
// Scans in a row that prove a pane absent.
const MOST_MISSES = 3u;
// Scans in which a pane ended at open air that prove that it does not go on there.
const AIR_SCANS = 3.0;
// Glass that shows this far beyond such an end takes it back, metres.
const PAST_END_M = 0.3;
// Scans that must have found a pane before what is seen through it makes none.
const LEAST_HITS_BEFORE = 2u;
// How far behind it that must lie, metres.
const BEHIND_M = 1.0;
// A pane that one scan alone found goes away after this many without it.
const LONE_SCANS = 10u;

// The panes by which this scan is labelled.
var<private> shown: array<Pane, KEPT_PANES>;

fn rotation() -> mat3x3<f32> {
    return transpose(mat3x3<f32>(
        glass_params.local_from_lidar_x.xyz,
        glass_params.local_from_lidar_y.xyz,
        glass_params.local_from_lidar_z.xyz,
    ));
}

fn lidar_in_map() -> vec3<f32> {
    return vec3(
        glass_params.local_from_lidar_x.w,
        glass_params.local_from_lidar_y.w,
        glass_params.local_from_lidar_z.w,
    );
}

fn upright_axis(pane: Pane) -> vec3<f32> {
    return cross(pane.normal.xyz, pane.level.xyz);
}

// The pane after a rotation and a shift of everything.
fn moved(pane: Pane, turn: mat3x3<f32>, shift: vec3<f32>) -> Pane {
    var out = pane;
    out.normal = vec4(turn * pane.normal.xyz, 0.0);
    out.level = vec4(turn * pane.level.xyz, pane.level.w);
    out.normal.w = pane.normal.w + dot(out.normal.xyz, shift);
    let by = vec2(dot(out.level.xyz, shift), dot(upright_axis(out), shift));
    out.extent = pane.extent + by.xxyy;
    return out;
}

fn to_map(pane: Pane) -> Pane {
    return moved(pane, rotation(), lidar_in_map());
}

// With the normal away from the sensor, as all that labels by it takes for granted.
fn to_lidar(pane: Pane) -> Pane {
    let turn = transpose(rotation());
    var out = moved(pane, turn, -(turn * lidar_in_map()));
    if out.normal.w < 0.0 {
        // n and u turn round, so v = n x u stays.
        out.normal = -out.normal;
        out.level = vec4(-out.level.xyz, out.level.w);
        out.extent = vec4(-out.extent.y, -out.extent.x, out.extent.z, out.extent.w);
    }
    return out;
}

fn centre(pane: Pane) -> vec3<f32> {
    let e = pane.extent;
    return pane.normal.xyz * pane.normal.w + pane.level.xyz * 0.5 * (e.x + e.y) + upright_axis(pane) * 0.5 * (e.z + e.w);
}

// Extents of `other` in the axes of `pane`: centre moved over, sizes kept.
fn extent_in(pane: Pane, other: Pane) -> vec4<f32> {
    let at = centre(other);
    let mid = vec2(dot(at, pane.level.xyz), dot(at, upright_axis(pane)));
    let half = 0.5 * vec2(other.extent.y - other.extent.x, other.extent.w - other.extent.z);
    return vec4(mid.x - half.x, mid.x + half.x, mid.y - half.y, mid.y + half.y);
}

fn united(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return vec4(min(a.x, b.x), max(a.y, b.y), min(a.z, b.z), max(a.w, b.w));
}

// What a pane of a scan shows of its ends along u of `old`: least and largest u at which it shows glass; 1 where it ends
// at open air on that side, else 0.
fn ends_in(old: Pane, fresh: Pane, number: u32) -> vec4<f32> {
    let ends = scan_ends[number];
    let foot = fresh.normal.xyz * fresh.normal.w + upright_axis(fresh) * 0.5 * (fresh.extent.z + fresh.extent.w);
    let along = dot(fresh.level.xyz, old.level.xyz);
    // From the lidar's foot to the map's: as the extent was moved.
    let shift = fresh.extent.x - scan_panes[number].extent.x;
    let shown = vec2(dot(foot, old.level.xyz)) + along * (ends.xy + shift);
    return select(vec4(shown.yx, ends.wz), vec4(shown, ends.zw), vec4(along > 0.0));
}

// Whether a pane shows glass only beyond an end of a kept one at which there is open air.
fn is_past_end(slot: u32, ends: vec4<f32>) -> bool {
    let kept_at = kept_ends[slot];
    return (kept_at.z >= AIR_SCANS && ends.y < kept_at.x) || (kept_at.w >= AIR_SCANS && ends.x > kept_at.y);
}

// The ends of a kept pane after one more scan, and its extent within those that are proven.
fn ended(slot: u32, pane: Pane, seen: vec4<f32>, ends: vec4<f32>) -> Pane {
    var at = kept_ends[slot];
    let past = vec2((at.x - ends.x), (ends.y - at.y)) > vec2(PAST_END_M);
    let air = ends.zw > vec2(0.0);
    let counts = select(select(at.zw, vec2(0.0), past), min(at.zw + 1.0, vec2(AIR_SCANS)), air);
    at = vec4(select(at.xy, seen.xy, air), counts);
    kept_ends[slot] = at;
    var out = pane;
    out.extent.x = select(pane.extent.x, max(pane.extent.x, at.x), at.z >= AIR_SCANS);
    out.extent.y = select(pane.extent.y, min(pane.extent.y, at.y), at.w >= AIR_SCANS);
    return out;
}

// How far the extents of two panes in one plane are apart along the axis in which they are farthest; 1e9 where their planes differ.
fn apart_in_plane(old: Pane, fresh: Pane) -> f32 {
    let off = dot(old.normal.xyz, centre(fresh)) - old.normal.w;
    let differ = old.id == 0u || abs(dot(old.normal.xyz, fresh.normal.xyz)) < SAME_COS || abs(off) >= SAME_M;
    let e = extent_in(old, fresh);
    let apart = vec4(e.x - old.extent.y, old.extent.x - e.y, e.z - old.extent.w, old.extent.z - e.w);
    return select(max(max(apart.x, apart.y), max(apart.z, apart.w)), 1e9, differ);
}

fn is_same(old: Pane, fresh: Pane) -> bool {
    return is_mirror(old) == is_mirror(fresh) && apart_in_plane(old, fresh) < SAME_EDGE_M;
}

// Whether a place that this scan says is a mirror is known for glass, or the other way round.
fn is_known_otherwise(fresh: Pane) -> bool {
    var known = false;
    for (var k = 0u; k < KEPT_PANES; k++) {
        let old = kept.panes[k];
        let otherwise = is_mirror(old) != is_mirror(fresh) && apart_in_plane(old, fresh) < 0.0;
        known = known || (otherwise && old.hits >= LEAST_HITS_BEFORE);
    }
    return known;
}

// The mean plane through the mean of the centres, weighted by scans; extents united.
fn refined(old: Pane, given: Pane) -> Pane {
    var fresh = given;
    if dot(old.normal.xyz, fresh.normal.xyz) < 0.0 {
        fresh.normal = -fresh.normal;
        fresh.level = vec4(-fresh.level.xyz, fresh.level.w);
        fresh.extent = vec4(-fresh.extent.y, -fresh.extent.x, fresh.extent.z, fresh.extent.w);
    }
    let weight = f32(min(old.hits, MOST_HITS));
    var out = old;
    let n = normalize(old.normal.xyz * weight + fresh.normal.xyz);
    let here = centre(fresh);
    let off = dot(old.normal.xyz, here) - old.normal.w;
    let through = here - old.normal.xyz * off * weight / (weight + 1.0);
    out.normal = vec4(n, dot(n, through));
    out.level = vec4(normalize(old.level.xyz - n * dot(n, old.level.xyz)), fresh.level.w);
    out.extent = united(extent_in(out, old), extent_in(out, fresh));
    out.hits = old.hits + 1u;
    out.misses = 0u;
    return out;
}

fn forgets(pane: Pane, slot: u32) -> Pane {
    var out = pane;
    let showing = pane_counts[slot * PANE_COUNTS + SHOWING];
    let passing = pane_counts[slot * PANE_COUNTS + PASSING];
    out.age += 1u;
    if showing + passing >= LEAST_HEAD_ON {
        let least = select(LEAST_SHOWING, LEAST_MIRRORED, is_mirror(pane));
        let absent = f32(showing) < least * f32(showing + passing);
        out.misses = select(0u, pane.misses + 1u, absent);
    }
    let lone = pane.hits == 1u && out.age > LONE_SCANS;
    if out.misses >= MOST_MISSES || lone {
        out.id = 0u;
    }
    return out;
}

// The slot for a pane of this scan: of the same pane, else an empty one, else that of the one found least often.
fn slot_for(pane: Pane, number: u32) -> u32 {
    var slot = 0u;
    var least = NONE;
    for (var k = 0u; k < KEPT_PANES; k++) {
        if is_same(kept.panes[k], pane) && !is_past_end(k, ends_in(kept.panes[k], pane, number)) {
            return k;
        }
        let hits = select(kept.panes[k].hits + 1u, 0u, kept.panes[k].id == 0u);
        if hits < least {
            least = hits;
            slot = k;
        }
    }
    return slot;
}

// Whether a pane of this scan stands behind a kept one. Through glass a wall gives two returns too: itself, and what the glass
// mirrors farther off.
fn is_behind(seen: Pane, number: u32) -> bool {
    let ends = scan_ends[number];
    let e = seen.extent;
    let at = seen.normal.xyz * seen.normal.w + seen.level.xyz * 0.5 * (ends.x + ends.y) + upright_axis(seen) * 0.5 * (e.z + e.w);
    var behind = false;
    for (var k = 0u; k < KEPT_PANES; k++) {
        let crossing = cross_pane(shown[k], at, 0.0);
        behind = behind || (crossing.inside && crossing.over > BEHIND_M && kept.panes[k].hits >= LEAST_HITS_BEFORE);
    }
    return behind;
}

fn take_in(number: u32) {
    let seen = scan_panes[number];
    var fresh = to_map(seen);
    if is_known_otherwise(fresh) {
        return;
    }
    let slot = slot_for(fresh, number);
    let old = kept.panes[slot];
    let ends = ends_in(old, fresh, number);
    var current = seen;
    let known = is_same(old, fresh) && !is_past_end(slot, ends);
    if known && old.hits <= LEAST_HITS_BEFORE && is_behind(seen, number) {
        // Found in the same scan as what it is seen through.
        kept.panes[slot].id = 0u;
        shown[slot].id = 0u;
        return;
    }
    if known {
        let seen_extent = extent_in(old, fresh);
        fresh = ended(slot, refined(old, fresh), seen_extent, ends);
        // This scan's own plane fits it best, as poses have errors; the boundaries are the kept ones.
        current.extent = extent_in(seen, to_lidar(fresh));
    } else if is_behind(seen, number) {
        return;
    } else {
        kept.last_id += 1u;
        fresh.id = kept.last_id;
        kept_ends[slot] = vec4(fresh.extent.xy, scan_ends[number].zw);
        fresh.hits = 1u;
        fresh.misses = 0u;
        fresh.age = 1u;
    }
    kept.panes[slot] = fresh;
    current.id = fresh.id;
    current.hits = fresh.hits;
    current.misses = 0u;
    current.age = fresh.age;
    shown[slot] = current;
}

fn store(slot: u32, slots: u32) {
    let pane = shown[slot];
    panes.list[slot] = pane;
    textureStore(pane_texels, vec2(0u, slot), 0u, pane.normal);
    textureStore(pane_texels, vec2(1u, slot), 0u, pane.level);
    textureStore(pane_texels, vec2(2u, slot), 0u, pane.extent);
    textureStore(pane_texels, vec2(3u, slot), 0u, vec4(f32(pane.id), f32(pane.hits), f32(slots), 0.0));
}

@compute @workgroup_size(64)
fn remember(@builtin(local_invocation_index) lane: u32) {
    if lane == 0u {
        for (var k = 0u; k < KEPT_PANES; k++) {
            if glass_params.remembers == 0u || glass_params.replaces == 1u {
                kept.panes[k].id = 0u;
            } else if kept.panes[k].id != 0u {
                kept.panes[k] = forgets(kept.panes[k], k);
            }
        }
        for (var k = 0u; k < min(glass_params.loaded, KEPT_PANES); k++) {
            kept.panes[k] = loaded_panes[k];
            kept_ends[k] = vec4(0.0);
            kept.last_id = max(kept.last_id, loaded_panes[k].id);
        }
        for (var k = 0u; k < KEPT_PANES; k++) {
            shown[k] = to_lidar(kept.panes[k]);
        }
        for (var k = 0u; k < min(found.panes + found.mirrors, SCAN_PANES + SCAN_MIRRORS); k++) {
            take_in(k);
        }
        var slots = 0u;
        for (var k = 0u; k < KEPT_PANES; k++) {
            slots = select(slots, k + 1u, kept.panes[k].id != 0u);
        }
        panes.slots = slots;
        for (var k = 0u; k < KEPT_PANES; k++) {
            store(k, slots);
        }
        met_points[MET_COUNT] = 0u;
        for (var k = 0u; k < KEPT_PANES * PANE_COUNTS; k++) {
            pane_counts[k] = 0u;
        }
    }
}
