// Takes the widest opening of each wall behind which lies what the room before it would be in a mirror, and nothing else. spec 6 §4.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var<storage, read> scan_walls: Walls;
@group(0) @binding(2) var<storage, read> wall_strips: array<u32>;
@group(0) @binding(3) var<storage, read_write> found: Found;
@group(0) @binding(4) var<storage, read_write> scan_panes: array<Pane>;
@group(0) @binding(5) var<storage, read_write> scan_ends: array<vec4<f32>>;
@group(0) @binding(6) var<storage, read_write> glass_counters: array<u32>;

const LANES = 64u;
// Beams that go on in a strip of an opening, and strips with fewer that do not part it.
const LEAST_IN_STRIP = 4u;
const MOST_GAP = 2u;
// Beams that go on in an opening, times those that a pane needs; of them the share with two returns.
const MORE_GO_ON = 4u;
const MOST_TWICE = 0.2;
// Of the mirrored places that the scan shows something of: surfaces, and those that the sensor sees through.
const LEAST_IMAGES = 0.6;
const MOST_REFUTED = 0.03;
// Proofs, and for each place that the sensor sees through and each that has no surface so many more.
const LEAST_PROOFS = 8.0;
const PROOFS_FOR_REFUTED = 2.0;
const PROOFS_FOR_MISSING = 0.05;
// Beams with which glass shows itself away from the opening's ends, as a share of those that go on.
const MOST_GLAZED = 0.3;
// Beams of a scan that must have two returns: edges alone give some, to a sensor that has them.
const LEAST_DUAL = 4u;
const M_PER_MM = 0.001;

struct Opening {
    first: u32,     // strip
    end: u32,       // one past the last; 0: there is none
    go_on: u32,
}

var<workgroup> openings: array<Opening, WALLS>;

fn strip_word(wall: u32, strip: u32, what: u32) -> u32 {
    return wall_strips[strip_at(wall, strip) + what];
}

fn summed(wall: u32, from_strip: u32, end: u32, what: u32) -> u32 {
    var sum = 0u;
    for (var k = from_strip; k < end; k++) {
        sum += strip_word(wall, k, what);
    }
    return sum;
}

fn is_mirror_between(wall: u32, first: u32, end: u32) -> bool {
    let all = f32(summed(wall, first, end, GO_ON));
    let images = f32(summed(wall, first, end, IMAGES));
    let missing = f32(summed(wall, first, end, MISSING));
    let refuted = f32(summed(wall, first, end, REFUTED));
    let needed = LEAST_PROOFS + PROOFS_FOR_REFUTED * refuted + PROOFS_FOR_MISSING * missing;
    return all >= f32(MORE_GO_ON * glass_params.min_behind) && f32(summed(wall, first, end, PROOFS)) >= needed
        && images >= LEAST_IMAGES * (images + missing) && refuted <= MOST_REFUTED * (images + missing)
        && f32(summed(wall, first, end, TWICE)) <= MOST_TWICE * all
        && f32(summed(wall, first + 1u, max(end, 1u) - 1u, GLAZED)) <= MOST_GLAZED * all;
}

// Of a wall's openings that are mirrors the one through which most beams go.
fn widest(wall: u32) -> Opening {
    var best = Opening(0u, 0u, 0u);
    var first = 0u;
    var end = 0u;
    var gap = 0u;
    for (var k = 0u; k < STRIPS + MOST_GAP + 1u; k++) {
        let open = k < STRIPS && strip_word(wall, min(k, STRIPS - 1u), GO_ON) >= LEAST_IN_STRIP;
        if open {
            first = select(first, k, end == 0u);
            end = k + 1u;
            gap = 0u;
        } else {
            gap += 1u;
        }
        if gap > MOST_GAP && end > 0u {
            let go_on = summed(wall, first, end, GO_ON);
            if go_on > best.go_on && is_mirror_between(wall, first, end) {
                best = Opening(first, end, go_on);
            }
            end = 0u;
        }
    }
    return best;
}

fn mirror_in(wall: u32, opening: Opening) -> Pane {
    let plane = scan_walls.planes[wall];
    var low = NONE;
    var high = 0u;
    for (var k = opening.first; k < opening.end; k++) {
        low = min(low, strip_word(wall, k, LOWEST));
        high = max(high, strip_word(wall, k, HIGHEST));
    }
    let u = STRIP_M * (vec2(f32(opening.first), f32(opening.end)) - 0.5 * f32(STRIPS));
    let v = M_PER_MM * (vec2(f32(low), f32(high)) - V_ZERO_MM);
    return Pane(plane, vec4(scan_walls.levels[wall].xyz, MIRROR_LEVEL), vec4(u, v), 1u, 1u, 0u, 1u);
}

@compute @workgroup_size(LANES)
fn mirrors(@builtin(local_invocation_index) lane: u32) {
    // Where beams have one return only, glass that shows its image by some and what is behind it by others looks as a mirror does.
    let two = glass_counters[COUNT_DUAL] >= LEAST_DUAL;
    if lane < WALLS {
        openings[lane] = Opening(0u, 0u, 0u);
        if two && scan_walls.planes[lane].w > 0.0 {
            openings[lane] = widest(lane);
        }
    }
    workgroupBarrier();
    if lane == 0u {
        var count = 0u;
        for (var wall = 0u; wall < WALLS; wall++) {
            if openings[wall].end > 0u && count < SCAN_MIRRORS {
                let mirror = mirror_in(wall, openings[wall]);
                scan_panes[found.panes + count] = mirror;
                scan_ends[found.panes + count] = vec4(mirror.extent.xy, 0.0, 0.0);
                count += 1u;
            }
        }
        found.mirrors = count;
        glass_counters[COUNT_MIRRORS] = count;
    }
}
