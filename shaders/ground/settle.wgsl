// Fits the best of the planes that were drawn, refuses those that are no ground, and joins the one that is with what is kept;
// says from which plane the passes after it count heights. spec 6 §2.
@group(0) @binding(0) var<uniform> ground_params: GroundParams;
@group(0) @binding(1) var ground_samples: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(2) var<storage, read> ground_planes: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> ground_scores: array<u32>;
@group(0) @binding(4) var<storage, read_write> ground: array<Kept>;
// 0: height of a place above the ground, as a scalar product with (place, 1). 1: where that comes from (0 stated, 1 this sensor,
// 2 another), the sensor's height above it, squares that showed this message's plane and squares that were looked through, m2.
// 2: the plane as kept for this sensor, from the sensor. 3: what this message showed (2 the ground, 1 a plane that is refused as
// it lies where the ground cannot be), share of the samples on it, messages that showed the ground, 1 where the stated ground is
// taken as it agrees. 4: the plane that this message showed, from the sensor.
@group(0) @binding(5) var<storage, read_write> ground_now: array<vec4<f32>, 5>;

const LANES = 128u;
// Planes that are fitted: the one that is expected, and the ones with most samples that differ.
const CANDIDATES = 5u;
// Refits, by samples nearer and nearer, so that the feet of walls count no more: share of the tolerance of the first, and by
// which it falls.
const REFITS = 5u;
const FIRST_SHARE = 1.0;
const EXPECTED_SHARE = 0.5;
const FALLING = 0.75;
// Two planes are one where their heights, and slopes, differ less.
const SAME_M = 0.1;
const SAME_SLOPE = 0.05;
// Least squares: variance along the ground, m2, below which gravity, or the last plane, decides the slope.
const PRIOR_M2 = 0.006;
// What a ground needs: samples, and m2 of squares.
const LEAST_SAMPLES = 24u;
const LEAST_AREA_M2 = 0.4;
// Share of its squares, and of its samples, as many as which may be looked through beside it, to something below: more, and it is
// a table. What is expected may be the edge of a platform.
const MOST_PIERCED = 0.25;
// How far it must reach: in this share of the directions that show it the farthest sample is so many times as far as the nearest.
// The line that one ring draws on walls around a lidar is no ground.
const LEAST_SPREAD = 1.3;
const LEAST_SPREAD_SHARE = 0.3;
const SPREAD_STEPS_PER_M = 1024.0;
// What lies less than this below a plane does not count as below, metres.
const BELOW_M = 0.1;
// What the base tells: the ground is no higher above it than this, and no deeper below it and the stated ground, metres.
const MOST_ABOVE_BASE_M = 0.12;
const MOST_BELOW_BASE_M = 0.35;
// The same where the base is assumed to stand on the stated ground, right under a camera: a table is higher.
const MOST_ABOVE_ASSUMED_M = 0.35;
// A plane as it was expected counts so much more, and less the more it differs: by how much in height and slope. Else one that
// runs through the floor and the foot of a ramp, or the lower floor below the edge of a platform, would have more area.
const EXPECTED_COUNTS = 30.0;
const EXPECTED_WITHIN_M = 0.05;
const EXPECTED_WITHIN_SLOPE = 0.03;
// As far as this it may still be the edge of a platform.
const EDGE_SHARE = 0.15;
const EXPECTED_M = 0.06;
const EXPECTED_SLOPE = 0.05;
// From one message to the next the ground moves no more than this once ESTABLISHED messages showed it; and two sensors
// that see one floor differ by no more than their mounts are wrong.
const ESTABLISHED = 3u;
const MOST_STEP_M = 0.12;
const MOST_STEP_SLOPE = 0.09;
const MOST_MOUNT_M = 0.35;
const MOST_MOUNT_SLOPE = 0.2;
// Steps of the distance to the stated ground a metre.
const APART_STEPS_PER_M = 10000.0;
// Time in which the kept plane follows what is seen, ticks of 0.01 s.
const FOLLOW_TICKS = 50.0;

var<workgroup> sums: array<vec4<f32>, LANES>;       // weight; x, y, off
var<workgroup> squares: array<vec4<f32>, LANES>;    // xx, xy, yy
var<workgroup> products: array<vec4<f32>, LANES>;   // x off, y off; samples on the plane, samples
var<workgroup> shown: array<atomic<u32>, FIELD_WORDS>;
var<workgroup> pierced: array<atomic<u32>, FIELD_WORDS>;
var<workgroup> nearest: array<atomic<u32>, SPREAD_SECTORS>;    // by direction; inverted, 0: none
var<workgroup> farthest: array<atomic<u32>, SPREAD_SECTORS>;
var<workgroup> pierced_samples: atomic<u32>;
var<workgroup> most_apart: atomic<u32>;
var<workgroup> plane_now: vec3<f32>;                // z = x a + y b + c; c of no plane is above 0
var<workgroup> tried: array<vec3<f32>, CANDIDATES>;

fn count_of_samples() -> u32 {
    return min(ground_params.columns * ground_params.rows, MOST_SAMPLES);
}

// What is expected: the ground as it is known, else as it is stated, else level, at no height.
fn expected() -> vec3<f32> {
    let known = best_kept();
    if known < ground_params.sensors {
        return slopes_of(from_sensor(ground[known]));
    }
    return vec3(0.0, 0.0, select(1.0, ground_params.stated_z - sensor_place().z, ground_params.has_map == 1u));
}

// How much more a plane counts as it is like the expected one.
fn like_expected(plane: vec3<f32>) -> f32 {
    let wanted = expected();
    let apart = (height_at(plane, ground_params.base.xy) - height_at(wanted, ground_params.base.xy)) / EXPECTED_WITHIN_M;
    let turned_by = length(plane.xy - wanted.xy) / EXPECTED_WITHIN_SLOPE;
    return select(0.0, EXPECTED_COUNTS * exp(-apart * apart - turned_by * turned_by), is_plane(wanted));
}

// The plane with most samples, the first of equals, that is none of those before; at first the one that is expected.
fn next_plane(turn: u32) -> vec3<f32> {
    if turn == 0u {
        return expected();
    }
    var best = vec3(0.0, 0.0, 1.0);
    var most = LEAST_SAMPLES - 1u;
    for (var k = 0u; k < HYPOTHESES; k++) {
        if ground_scores[k] > most {
            let plane = slopes_of(ground_planes[k]);
            var is_new = true;
            for (var t = 0u; t < turn; t++) {
                is_new = is_new && !is_same(plane, tried[min(t, CANDIDATES - 1u)], vec2(0.0), SAME_M, SAME_SLOPE);
            }
            if is_new {
                most = ground_scores[k];
                best = plane;
            }
        }
    }
    return best;
}

fn off_plane(taken: vec4<f32>) -> f32 {
    return taken.z - height_at(plane_now, taken.xy);
}

// Sums over the samples of a lane that lie within a share of their tolerance on the plane.
fn sum_up(lane: u32, count: u32, share: f32) {
    var sum = vec4(0.0);
    var square = vec4(0.0);
    var product = vec4(0.0);
    for (var k = lane; k < min(count, MOST_SAMPLES); k += LANES) {
        let taken = textureLoad(ground_samples, sample_texel(k), 0u);
        let off = off_plane(taken);
        let is_on = abs(off) < share * taken.w;
        let weight = select(0.0, 1.0 / max(taken.w * taken.w, 1.0e-6), is_on);
        sum += weight * vec4(1.0, taken.xy, off);
        square += weight * vec4(taken.x * taken.x, taken.x * taken.y, taken.y * taken.y, 0.0);
        product += vec4(weight * taken.xy * off, select(0.0, 1.0, is_on), select(0.0, 1.0, taken.w > 0.0));
    }
    sums[lane] = sum;
    squares[lane] = square;
    products[lane] = product;
}

// The plane moved to the least squares of the sums, with a pull to the expected slope where samples decide little.
fn refitted(plane: vec3<f32>, pull: vec2<f32>) -> vec3<f32> {
    var sum = vec4(0.0);
    var square = vec4(0.0);
    var product = vec4(0.0);
    for (var k = 0u; k < LANES; k++) {
        sum += sums[k];
        square += squares[k];
        product += products[k];
    }
    if product.z < 3.0 {
        return vec3(0.0, 0.0, 1.0);
    }
    let mean = sum.yzw / sum.x;
    let spread = square.xyz / sum.x - vec3(mean.x * mean.x, mean.x * mean.y, mean.y * mean.y);
    let a = max(spread.x, 0.0) + PRIOR_M2;
    let c = max(spread.z, 0.0) + PRIOR_M2;
    let b = spread.y;
    let along = product.xy / sum.x - mean.xy * mean.z + PRIOR_M2 * (pull - plane.xy);
    let turn = vec2(c * along.x - b * along.y, a * along.y - b * along.x) / max(a * c - b * b, 1.0e-6);
    return plane + vec3(turn, mean.z - dot(turn, mean.xy));
}

fn is_shown(at: vec2<f32>) -> bool {
    let square = square_of(at);
    return square.x < FIELD_WORDS && ((atomicLoad(&shown[min(square.x, FIELD_WORDS - 1u)]) >> square.y) & 1u) == 1u;
}

// Whether the plane shows where the beam to a sample crosses it, or beside that.
fn is_shown_near(at: vec2<f32>) -> bool {
    var near = false;
    for (var k = 0u; k < 9u; k++) {
        near = near || is_shown(at + ground_params.square_m * (vec2(f32(k % 3u), f32(k / 3u)) - 1.0));
    }
    return near;
}

fn mark_shown(lane: u32, count: u32) {
    for (var k = lane; k < min(count, MOST_SAMPLES); k += LANES) {
        let taken = textureLoad(ground_samples, sample_texel(k), 0u);
        if abs(off_plane(taken)) < taken.w {
            let square = square_of(taken.xy);
            if square.x < FIELD_WORDS {
                atomicOr(&shown[square.x], 1u << square.y);
            }
            let steps = u32(length(taken.xy) * SPREAD_STEPS_PER_M);
            let sector = sector_of(taken.xy);
            atomicMax(&nearest[sector], ~steps);
            atomicMax(&farthest[sector], steps);
        }
    }
}

// Whether the plane reaches far enough in enough of the directions that show it.
fn is_spread() -> bool {
    var directions = 0.0;
    var spread = 0.0;
    for (var k = 0u; k < SPREAD_SECTORS; k++) {
        let near = atomicLoad(&nearest[k]);
        let reach = f32(atomicLoad(&farthest[k])) / f32(max(~near, 1u));
        directions += select(0.0, 1.0, near != 0u);
        spread += select(0.0, 1.0, near != 0u && reach >= LEAST_SPREAD);
    }
    return spread > 0.0 && spread >= LEAST_SPREAD_SHARE * directions;
}

// What lies below the plane is seen through it, or in it as in a mirror: then the plane shows where the beam crosses it.
fn mark_pierced(lane: u32, count: u32) {
    for (var k = lane; k < min(count, MOST_SAMPLES); k += LANES) {
        let taken = textureLoad(ground_samples, sample_texel(k), 0u);
        let off = off_plane(taken);
        if taken.w > 0.0 && off < -max(2.0 * taken.w, BELOW_M) {
            let at = taken.xy * (plane_now.z / (plane_now.z + off));
            let square = square_of(at);
            if square.x < FIELD_WORDS && !is_shown_near(at) {
                atomicOr(&pierced[square.x], 1u << square.y);
                atomicAdd(&pierced_samples, 1u);
            }
        }
    }
}

// Whether the robot can stand on the plane, by where its base is.
fn is_under_base(plane: vec3<f32>) -> bool {
    if ground_params.base.w == BASE_UNKNOWN || ground_params.has_map == 0u {
        return true;
    }
    let height = height_at(plane, ground_params.base.xy);
    let assumed = ground_params.base.w == BASE_ASSUMED;
    let lowest = min(ground_params.stated_z - sensor_place().z, ground_params.base.z) - MOST_BELOW_BASE_M;
    let highest = ground_params.base.z + select(MOST_ABOVE_BASE_M, MOST_ABOVE_ASSUMED_M, assumed);
    return height <= highest && (assumed || height >= lowest);
}

// Whether the plane goes on from what is kept.
fn goes_on(plane: vec3<f32>) -> bool {
    let known = best_kept();
    if known >= ground_params.sensors {
        return true;
    }
    let kept = slopes_of(from_sensor(ground[known]));
    if known != ground_params.sensor {
        return is_same(plane, kept, ground_params.base.xy, MOST_MOUNT_M, MOST_MOUNT_SLOPE);
    }
    return ground[known].count < ESTABLISHED || is_same(plane, kept, ground_params.base.xy, MOST_STEP_M, MOST_STEP_SLOPE);
}

fn judged(plane: vec3<f32>) -> Found {
    var on = vec2(0.0);
    for (var k = 0u; k < LANES; k++) {
        on += products[k].zw;
    }
    var counts = vec2(0u);
    for (var k = 0u; k < FIELD_WORDS; k++) {
        counts += vec2(countOneBits(atomicLoad(&shown[k])), countOneBits(atomicLoad(&pierced[k])));
    }
    let areas = vec2<f32>(counts) * ground_params.square_m * ground_params.square_m;
    let is_level = is_plane(plane) && plane.z < -ground_params.least_height_m && length(plane.xy) <= ground_params.most_slope
        && on.x >= f32(LEAST_SAMPLES) && areas.x >= LEAST_AREA_M2 && is_spread();
    let is_whole = areas.y <= MOST_PIERCED * areas.x && f32(atomicLoad(&pierced_samples)) <= MOST_PIERCED * on.x;
    let near = on.x >= EDGE_SHARE * on.y
        && is_same(plane, expected(), ground_params.base.xy, EXPECTED_M, EXPECTED_SLOPE);
    var found = Found(plane, 0.0, is_level && (near || is_whole), areas.x, areas.y, on.x / max(on.y, 1.0));
    if found.level && is_under_base(plane) && goes_on(plane) {
        found.value = areas.x * (1.0 + like_expected(plane));
    }
    return found;
}

// The plane as it is kept now; none where this message did not show the ground.
fn keep(found: Found) -> vec3<f32> {
    let old = ground[ground_params.sensor];
    if found.value == 0.0 {
        return vec3(0.0, 0.0, 1.0);
    }
    var kept = Kept(vec4(0.0), max(ground_params.tick, 1u), 1u, found.area_m2, 0u);
    var plane = found.plane;
    if is_fresh(old) {
        let since = f32(max(ground_params.tick, old.tick) - old.tick);
        let gain = max(1.0 / f32(old.count + 1u), 1.0 - exp(-since / FOLLOW_TICKS));
        plane = mix(slopes_of(from_sensor(old)), plane, gain);
        kept.count = min(old.count + 1u, MOST_COUNT);
        kept.tick = max(old.tick, kept.tick);
    }
    let normal = normal_of(plane);
    kept.plane = vec4(normal.xyz, normal.w + dot(normal.xyz, sensor_place()));
    ground[ground_params.sensor] = kept;
    return plane;
}

// Whether the stated ground is as good, as where the plane is seen the two differ less than noise may make them.
fn keep_agreement() {
    let apart = f32(atomicLoad(&most_apart)) / APART_STEPS_PER_M;
    let agrees = ground_params.has_map == 1u && apart > 0.0 && apart <= ground_params.agrees_m;
    ground[ground_params.sensor].agrees = select(0u, 1u, agrees);
}

// The largest distance between the plane and the stated ground where samples show it.
fn mark_apart(lane: u32, count: u32) {
    let stated = ground_params.stated_z - sensor_place().z;
    for (var k = lane; k < min(count, MOST_SAMPLES); k += LANES) {
        let taken = textureLoad(ground_samples, sample_texel(k), 0u);
        if abs(off_plane(taken)) < taken.w {
            let apart = abs(height_at(plane_now, taken.xy) - stated);
            atomicMax(&most_apart, u32(min(apart, 1000.0) * APART_STEPS_PER_M) + 1u);
        }
    }
}

fn tell(found: Found) {
    let known = best_kept();
    let is_known = known < ground_params.sensors;
    let zero = ground_params.zero.xyz;
    var heights = vec4(0.0, 0.0, 1.0, zero.z - ground_params.stated_z);
    var agreed = false;
    if is_known {
        let plane = ground[known].plane;
        agreed = ground[known].agrees == 1u;
        heights = select(vec4(plane.xyz, dot(plane.xyz, zero) - plane.w), heights, agreed);
    }
    let source = select(select(0.0, 2.0, is_known), 1.0, known == ground_params.sensor);
    let height = dot(heights, vec4(sensor_place() - zero, 1.0));
    let own = ground[ground_params.sensor];
    ground_now[0] = heights;
    ground_now[1] = vec4(source, height, found.area_m2, found.pierced_m2);
    ground_now[2] = select(NO_PLANE, from_sensor(own), is_fresh(own));
    let shown_as = select(select(0.0, 1.0, found.level), 2.0, found.value > 0.0);
    ground_now[3] = vec4(shown_as, found.share, f32(own.count), select(0.0, 1.0, agreed));
    ground_now[4] = select(NO_PLANE, normal_of(found.plane), found.level);
}

@compute @workgroup_size(LANES)
fn settle(@builtin(local_invocation_index) lane: u32) {
    let count = count_of_samples();
    var best = Found(vec3(0.0, 0.0, 1.0), 0.0, false, 0.0, 0.0, 0.0);
    for (var turn = 0u; turn < CANDIDATES; turn++) {
        if lane == 0u {
            plane_now = next_plane(turn);
            tried[turn] = plane_now;
        }
        workgroupBarrier();
        var share = select(FIRST_SHARE, EXPECTED_SHARE, turn == 0u);
        for (var k = 0u; k < REFITS; k++) {
            sum_up(lane, select(0u, count, is_plane(plane_now)), share);
            workgroupBarrier();
            if lane == 0u && is_plane(plane_now) {
                plane_now = refitted(plane_now, expected().xy);
            }
            share *= FALLING;
            workgroupBarrier();
        }
        let looked = select(0u, count, is_plane(plane_now));
        sum_up(lane, looked, 1.0);
        atomicStore(&shown[lane], 0u);
        atomicStore(&pierced[lane], 0u);
        atomicStore(&nearest[lane % SPREAD_SECTORS], 0u);
        atomicStore(&farthest[lane % SPREAD_SECTORS], 0u);
        atomicStore(&pierced_samples, 0u);
        workgroupBarrier();
        mark_shown(lane, looked);
        workgroupBarrier();
        mark_pierced(lane, looked);
        workgroupBarrier();
        if lane == 0u {
            let found = judged(plane_now);
            let is_shown = best.value == 0.0 && found.level && found.area_m2 > best.area_m2;
            if found.value > best.value || is_shown {
                best = found;
            }
        }
        workgroupBarrier();
    }
    if lane == 0u {
        plane_now = keep(best);
        atomicStore(&most_apart, 0u);
    }
    workgroupBarrier();
    mark_apart(lane, select(0u, count, is_plane(plane_now)));
    workgroupBarrier();
    if lane == 0u {
        if is_plane(plane_now) {
            keep_agreement();
        }
        tell(best);
    }
}
