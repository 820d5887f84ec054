// Decides whether the plane under test is a pane, finds its boundaries, and takes its candidates off the list.
// spec 3 §3, §4, §5 (panes with too few points behind them are dropped).
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var candidates: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(2) var<storage, read> survey: array<u32>;
@group(0) @binding(3) var<storage, read_write> found: Found;
@group(0) @binding(4) var left: texture_storage_2d_array<rgba32float, write>;
@group(0) @binding(5) var<storage, read_write> scan_panes: array<Pane>;
@group(0) @binding(6) var<storage, read_write> scores: array<u32>;
@group(0) @binding(7) var<storage, read_write> glass_counters: array<u32>;
@group(0) @binding(8) var<storage, read_write> scan_ends: array<vec4<f32>>;

const LANES = 128u;

// Of the beams that reach the plane where its candidates lie, at least this share shows glass: edges of things that
// happen to lie in one plane show it here and there only.
const LEAST_DENSITY = 0.1;
// Share of the candidates at each end that does not count for where they lie.
const TAIL_SHARE = 0.01;
// A pane goes on where at least this share of the beams shows glass or a view through; the rest is frame or wall.
const OPEN_SHARE = 0.3;
// Beams that a line of squares needs to say anything.
const LEAST_BEAMS = 3u;
// A pane stands in a frame or wall: z of the normal below that of 45 degrees. Beams that slip past edges onto the ground give
// two returns too, and the ground is flat.
const LEAST_LYING = 0.7;
// Two panes are farther apart than this, metres.
const NEAR_PANE_M = 0.3;
// Beside the patch where glass always shows, times its half width: from 20 to 32 degrees from head on, if it reaches to 16.
const BESIDE_FROM = 1.3;
// Glass shows around the foot of the sensor's perpendicular, as far as SHOWS_TO times the half width at most: at least this
// share of the beams that show glass lies there. Edges of things that happen to lie in one plane lie anywhere on it.
const LEAST_AROUND_FOOT = 0.5;
// A sensor that gives two returns shows glass by them, where light comes back from behind it.
const LEAST_DUAL = 0.3;
// Rings around the foot, so many to the half width, left and right of it: the outermost in which at least this share of the
// beams shows glass tells how far it shows in this scan, as glass shows the more the nearer to head on it is met.
const RINGS = 8u;
const RINGS_TO_REACH = 4u;
const LEAST_IN_RING = 0.3;
// Where glass would show itself, a line of squares is open air if it has this many beams and a smaller share shows glass.
const LEAST_NEAR = 6u;
const LEAST_SHOWING = 0.2;

// Lines of squares past an end at open air whose beams count as going on.
const PAST_END = 8u;

var<workgroup> around_foot: atomic<u32>;
var<workgroup> ring_shown: array<atomic<u32>, 16>;
var<workgroup> ring_beams: array<atomic<u32>, 16>;
var<workgroup> air_ends: vec2<bool>;   // whether the pane ends at open air where u is least, where it is largest
var<workgroup> core_ends: vec2<u32>;   // first and last line that shows glass
var<workgroup> visible_m: f32;         // how far from the foot glass shows in this scan, metres
var<workgroup> heads: array<vec2<u32>, LANES>;   // beams met head on, by whether they show glass
var<workgroup> nears: array<vec2<u32>, LANES>;
var<workgroup> sums: array<vec4<u32>, LANES>;
var<workgroup> bounds: vec4<u32>;      // first and last square of u, first and last of v
var<workgroup> accepted: bool;
var<workgroup> shown_in_all: u32;

fn counts_at(u: u32, v: u32) -> vec4<u32> {
    let at = v * SURVEY_WIDE + u;
    return vec4(
        survey[SHOWN * SURVEY_SQUARES + at] + survey[SHINING * SURVEY_SQUARES + at],
        survey[DIM * SURVEY_SQUARES + at],
        survey[BRIGHT * SURVEY_SQUARES + at],
        survey[BEYOND * SURVEY_SQUARES + at],
    );
}

// The half width of the patch around the foot in which glass shows, metres.
fn reach_m() -> f32 {
    return found.plane.w * sqrt(max(1.0 / (glass_params.visible_cos * glass_params.visible_cos) - 1.0, 0.0));
}

fn off_foot(u: u32, v: u32) -> f32 {
    let half = 0.5 * vec2(f32(SURVEY_WIDE), f32(SURVEY_HIGH));
    return SQUARE_M * length(vec2(f32(u), f32(v)) + 0.5 - half);
}

// Counts what an upright line of squares shows around the foot, by rings.
fn count_rings(line: u32) {
    let reach = reach_m();
    let around = u32(min(SHOWS_TO * reach / SQUARE_M + 1.0, 32.0));
    let begin = max(bounds.z, SURVEY_HIGH / 2u - around);
    let end = min(bounds.w + 1u, SURVEY_HIGH / 2u + around);
    let away = abs(f32(line) + 0.5 - 0.5 * f32(SURVEY_WIDE));
    for (var v = begin; v < select(begin, end, away < f32(around) && line >= bounds.x && line <= bounds.y); v++) {
        let off = off_foot(line, v);
        let counts = counts_at(line, v);
        let ring = u32(f32(RINGS_TO_REACH) * off / max(reach, 1e-3));
        let half = select(0u, RINGS, 2u * line >= SURVEY_WIDE);
        if off < SHOWS_TO * reach && counts.x > 0u {
            atomicAdd(&around_foot, counts.x);
        }
        if ring < RINGS {
            atomicAdd(&ring_shown[half + ring], counts.x);
            atomicAdd(&ring_beams[half + ring], counts.x + counts.y + counts.z + counts.w);
        }
    }
}

// How far glass shows, at most to where it always does.
fn visible_from_rings() -> f32 {
    var rings = 0u;
    for (var k = 0u; k < 2u * RINGS; k++) {
        let beams = atomicLoad(&ring_beams[k]);
        let shows = beams >= LEAST_NEAR && f32(atomicLoad(&ring_shown[k])) >= LEAST_IN_RING * f32(beams);
        rings = select(rings, max(rings, k % RINGS + 1u), shows);
    }
    return reach_m() * f32(min(rings, RINGS_TO_REACH)) / f32(RINGS_TO_REACH);
}

// Whether a line of squares is open air: glass would show there.
fn is_air(line: u32) -> bool {
    let near = nears[line];
    return near.x + near.y >= LEAST_NEAR && f32(near.x) < LEAST_SHOWING * f32(near.x + near.y);
}

// Where open air parts what shows glass along u, the part that shows most: its first and last line.
fn widest_part() -> vec2<u32> {
    var best = vec2(bounds.x, bounds.y);
    var most = 0u;
    var first = bounds.x;
    var last = bounds.x;
    var shown = 0u;
    for (var line = bounds.x; line < bounds.y + 2u; line++) {
        if line > bounds.y || is_air(line) {
            best = select(best, vec2(first, last), shown > most);
            most = max(most, shown);
            shown = 0u;
        } else if sums[line].x > 0u {
            first = select(first, line, shown == 0u);
            last = line;
            shown += sums[line].x;
        }
    }
    return best;
}

// Sums over one line of squares: number `line` along u (upright lines) or v, between the bounds of the other axis.
// And near the foot, beams that show glass and beams that go on.
fn line_sum(line: u32, upright: bool) -> array<vec4<u32>, 2> {
    var sum = vec4(0u);
    var near = vec4(0u);
    if upright && line < SURVEY_WIDE {
        for (var v = bounds.z; v < bounds.w + 1u; v++) {
            let counts = counts_at(line, v);
            sum += counts;
            near += select(vec4(0u), counts, off_foot(line, v) < visible_m);
        }
    }
    if !upright && line < SURVEY_HIGH {
        for (var u = bounds.x; u < bounds.y + 1u; u++) {
            let counts = counts_at(u, line);
            sum += counts;
            near += select(vec4(0u), counts, off_foot(u, line) < visible_m);
        }
    }
    return array(sum, near);
}

// Beams that show glass in one upright line of squares.
fn shown_in(line: u32) -> u32 {
    var sum = 0u;
    for (var v = bounds.z; v < bounds.w + 1u; v++) {
        let at = v * SURVEY_WIDE + line;
        sum += survey[SHOWN * SURVEY_SQUARES + at] + survey[SHINING * SURVEY_SQUARES + at];
    }
    return sum;
}

// Of an upright line of squares of the pane, beams that go through; that show glass by two returns; and to both sides of head
// on, where glass shows no more, beams that end there and beams that go on.
fn beams_at(line: u32) -> vec4<u32> {
    var sum = vec4(0u);
    // Beams past an end at open air count too: of a narrow pane none may slant enough to go on within it.
    let past = select(vec2(0u), vec2(PAST_END), air_ends);
    if line + past.x >= bounds.x && line <= bounds.y + past.y {
        let reach = reach_m();
        let u = SQUARE_M * (f32(line) + 0.5 - 0.5 * f32(SURVEY_WIDE));
        for (var row = bounds.z; row < bounds.w + 1u; row++) {
            let v = SQUARE_M * (f32(row) + 0.5 - 0.5 * f32(SURVEY_HIGH));
            let off = length(vec2(u, v));
            let beside = abs(v) < reach && off > BESIDE_FROM * reach && off < SHOWS_TO * reach;
            let shown = survey[SHOWN * SURVEY_SQUARES + row * SURVEY_WIDE + line];
            let counts = counts_at(line, row);
            let ends = select(0u, counts.x + counts.y + counts.z, beside);
            sum += vec4(shown + counts.w, shown, ends, select(0u, counts.w, beside));
        }
    }
    return sum;
}

// First and last line between which all but the tails of the candidates lie.
fn core(lines: u32) -> vec2<u32> {
    var total = 0u;
    for (var k = 0u; k < lines; k++) {
        total += sums[k].x;
    }
    let tail = u32(TAIL_SHARE * f32(total));
    var below = 0u;
    var first = 0u;
    var last = 0u;
    for (var k = 0u; k < lines; k++) {
        if below <= tail {
            first = k;
        }
        if below < total - tail {
            last = k;
        }
        below += sums[k].x;
    }
    return vec2(first, max(first, last));
}

// Whether the scan has beams with two returns: then glass shows by them, and what ends on the plane by one is none, however dim.
fn gives_two() -> bool {
    return glass_counters[COUNT_DUAL] >= glass_params.min_inliers;
}

fn measure(lane: u32, upright: bool) {
    let both = line_sum(lane, upright);
    sums[lane] = both[0];
    nears[lane] = vec2(both[1].x + both[1].y, both[1].w);
}

fn extent() -> vec4<f32> {
    let half = 0.5 * vec2(f32(SURVEY_WIDE), f32(SURVEY_HIGH));
    return SQUARE_M * vec4(
        f32(bounds.x) - half.x,
        f32(bounds.y) + 1.0 - half.x,
        f32(bounds.z) - half.y,
        f32(bounds.w) + 1.0 - half.y,
    );
}

fn pane_under_test() -> Pane {
    return Pane(found.plane, found.level, extent(), 1u, 1u, 0u, 1u);
}

// Whether a candidate is still to be explained.
fn stays(p: vec3<f32>, pane: Pane, tested: bool) -> bool {
    if !tested {
        return false;
    }
    let over = dot(pane.normal.xyz, p) - pane.normal.w;
    let on = abs(over) < glass_params.fit_tolerance_m;
    let crossing = cross_pane(pane, p, MARGIN_M);
    let behind = accepted && crossing.inside && crossing.over > 0.0;
    return !on && !(accepted && abs(over) < NEAR_PANE_M) && !behind;
}

@compute @workgroup_size(LANES)
fn accept(@builtin(local_invocation_index) lane: u32) {
    let tested = found.inliers > 0u;
    let pane_number = found.panes;
    if lane == 0u {
        // Without a plane under test all lines are empty.
        bounds = select(vec4(1u, 0u, 1u, 0u), vec4(0u, SURVEY_WIDE - 1u, 0u, SURVEY_HIGH - 1u), tested);
        accepted = false;
        visible_m = 0.0;
        air_ends = vec2(false);
        atomicStore(&around_foot, 0u);
    }
    if lane < 2u * RINGS {
        atomicStore(&ring_shown[lane], 0u);
        atomicStore(&ring_beams[lane], 0u);
    }
    workgroupBarrier();
    sums[lane] = vec4(shown_in(lane), 0u, 0u, 0u);
    workgroupBarrier();
    for (var once = 0u; once < turns_if(lane == 0u); once++) {
        let u = core(SURVEY_WIDE);
        bounds = select(bounds, vec4(u, bounds.zw), tested);
    }
    workgroupBarrier();
    measure(lane, false);
    workgroupBarrier();
    for (var once = 0u; once < turns_if(lane == 0u); once++) {
        let v = core(SURVEY_HIGH);
        bounds = select(bounds, vec4(bounds.xy, v), tested);
        var sum = vec4(0u);
        for (var k = v.x; k < v.y + 1u; k++) {
            sum += sums[k];
        }
        let dense = f32(sum.x) >= LEAST_DENSITY * f32(sum.x + sum.y + sum.z + sum.w);
        let stands = abs(found.plane.z) < LEAST_LYING;
        accepted = tested && dense && stands && sum.x > 0u && pane_number < SCAN_PANES;
        shown_in_all = sum.x;
    }
    workgroupBarrier();
    count_rings(lane);
    workgroupBarrier();
    for (var once = 0u; once < turns_if(lane == 0u); once++) {
        visible_m = visible_from_rings();
        accepted = accepted && f32(atomicLoad(&around_foot)) >= LEAST_AROUND_FOOT * f32(shown_in_all);
    }
    workgroupBarrier();
    for (var turn = 0u; turn < 2u; turn++) {
        measure(lane, true);
        workgroupBarrier();
        for (var once = 0u; once < turns_if(lane == 0u && tested); once++) {
            if turn == 0u {
                bounds = vec4(widest_part(), bounds.zw);
                core_ends = bounds.xy;
            }
            let u = vec2(grow(bounds.x, SURVEY_WIDE, false, true), grow(bounds.y, SURVEY_WIDE, true, true));
            bounds = select(bounds, vec4(u, bounds.zw), tested);
            air_ends = vec2(is_air(max(u.x, 1u) - 1u), is_air(min(u.y + 1u, SURVEY_WIDE - 1u)));
        }
        workgroupBarrier();
        measure(lane, false);
        workgroupBarrier();
        for (var once = 0u; once < turns_if(lane == 0u && tested); once++) {
            let v = vec2(grow(bounds.z, SURVEY_HIGH, false, false), grow(bounds.w, SURVEY_HIGH, true, false));
            bounds = select(bounds, vec4(bounds.xy, v), tested);
        }
        workgroupBarrier();
    }
    sums[lane] = beams_at(lane);
    heads[lane] = head_on_at(lane);
    workgroupBarrier();
    for (var once = 0u; once < turns_if(lane == 0u); once++) {
        var sum = vec4(0u);
        var head_on = vec2(0u);
        for (var k = 0u; k < LANES; k++) {
            sum += sums[k];
            head_on += heads[k];
        }
        let strings = gives_two() && head_on.x + head_on.y >= LEAST_HEAD_ON && head_on.y > head_on.x;
        // What shines head on and yet stops the beams beside is a wall with a gloss.
        let wall = sum.y == 0u && sum.z > sum.w;
        let single = gives_two() && f32(sum.y) < LEAST_DUAL * f32(shown_in_all);
        accepted = accepted && sum.x >= glass_params.min_behind && !wall && !single && !strings;
    }
    workgroupBarrier();
    let pane = pane_under_test();
    let count = found.candidates;
    let each = (select(0u, count, tested) + LANES - 1u) / LANES;
    let begin = min(lane * each, count);
    let end = min(begin + each, count);
    var kept = 0u;
    for (var k = begin; k < end; k++) {
        kept += select(0u, 1u, stays(candidate_at(k).xyz, pane, tested));
    }
    share_starts(lane, kept);
    var number = starts[lane];
    for (var k = begin; k < end; k++) {
        if stays(candidate_at(k).xyz, pane, tested) {
            textureStore(left, candidate_texel(number), 0u, candidate_at(k));
            number++;
        }
    }
    for (var k = lane; k < MOST_HYPOTHESES; k += LANES) {
        scores[k] = 0u;
    }
    storageBarrier();
    workgroupBarrier();
    if lane == 0u {
        if accepted {
            scan_panes[pane_number] = pane;
            let shown = SQUARE_M * (vec2<f32>(core_ends) + vec2(0.0, 1.0) - 0.5 * f32(SURVEY_WIDE));
            scan_ends[pane_number] = vec4(shown, select(vec2(0.0), vec2(1.0), air_ends));
            found.panes = pane_number + 1u;
            glass_counters[COUNT_FOUND] = pane_number + 1u;
        } else if tested {
            glass_counters[COUNT_REFUSED] += 1u;
        }
        found.candidates = total;
        found.inliers = 0u;
    }
}
