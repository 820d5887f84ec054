// Things that a ray passes between: thickets of thin elements, curtains of strings. Needs lib/sim/scene, lib/sim/random.
// spec 6 §1 (thickets by distance travelled, strings by their spacing).
const THICKET_HIT = 0x600u;
const CURTAIN_HIT = 0x700u;

// Where the random element of a ray is looked up, metres behind the place where the ray comes in.
const LOOK_UP_M = 0.5;

// Where a ray enters and leaves a thicket's bounds: a box, or the ellipsoid in it.
fn thicket_span(index: u32, origin: vec3<f32>, direction: vec3<f32>) -> vec2<f32> {
    let center = scene.thicket_center[index];
    let half = scene.thicket_half[index];
    let o = turned(origin - center.xyz, center.w, half.w) / half.xyz;
    let d = turned(direction, center.w, half.w) / half.xyz;
    if fract(0.5 * scene.thicket_look[index].w) > 0.25 {
        let a = max(dot(d, d), 1.0e-12);
        let b = dot(o, d);
        let under_root = b * b - a * (dot(o, o) - 1.0);
        let root = sqrt(max(under_root, 0.0));
        return select(vec2(FAR, -FAR), vec2(-b - root, -b + root) / a, under_root > 0.0);
    }
    let inverse = inverse_of(d);
    let middle = -o * inverse;
    let reach = abs(inverse);
    let first = middle - reach;
    let last = middle + reach;
    return vec2(max(first.x, max(first.y, first.z)), min(last.x, min(last.y, last.z)));
}

// Distance to the first element that a ray meets in a thicket. Rays that come in within an element's width of each
// other meet the same one, so that a thicket looks the same whenever it is looked at from the same place.
fn thicket_distance(index: u32, origin: vec3<f32>, direction: vec3<f32>, reach: f32) -> f32 {
    let look = scene.thicket_look[index];       // extinction 1/m, element width, material, shape
    let span = thicket_span(index, origin, direction);
    let start = max(span.x, 0.0);
    if start >= min(span.y, reach) || look.x <= 0.0 {
        return FAR;
    }
    let key = vec3<i32>(floor((origin + (start + LOOK_UP_M) * direction) / look.y));
    let chance = unit(hash(hash3(key.x, key.y, index + 71u) ^ bitcast<u32>(key.z)));
    let t = start - log(max(1.0 - chance, 1.0e-7)) / look.x;
    return select(FAR, t, t > NEAREST && t < min(span.y, reach));
}

// How far off the middle of a curtain's string a ray passes, as a share of the string's radius; above 1: between two.
fn string_offset(index: u32, at: vec3<f32>, direction: vec3<f32>) -> f32 {
    let look = scene.curtain_look[index];       // spacing, string width, half the curtain's width, material
    let u = scene.curtain_u[index];
    let along = (dot(u.xyz, at) - u.w) * look.z / look.x;
    let level = normalize(direction.xy + vec2(1.0e-9, 0.0));
    let facing = abs(dot(scene.curtain_plane[index].xy, level));
    return (fract(along) - 0.5) * look.x * facing / (0.5 * look.y);
}

fn curtain_distance(index: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let plane = scene.curtain_plane[index];
    let u = scene.curtain_u[index];
    let v = scene.curtain_v[index];
    let t = (plane.w - dot(plane.xyz, origin)) / away_from_zero(dot(plane.xyz, direction));
    let at = origin + t * direction;
    let inside = abs(dot(u.xyz, at) - u.w) <= 1.0 && abs(dot(v.xyz, at) - v.w) <= 1.0;
    let on_string = abs(string_offset(index, at, direction)) < 1.0;
    return select(FAR, t, inside && on_string && t > NEAREST);
}

// The nearer of a hit and what thin things a ray meets before it.
fn nearest_thin(hit: Hit, origin: vec3<f32>, direction: vec3<f32>) -> Hit {
    var nearest = hit;
    for (var i = 0u; i < scene.counts.z; i++) {
        let t = curtain_distance(i, origin, direction);
        nearest.id = select(nearest.id, CURTAIN_HIT | i, t < nearest.t);
        nearest.t = min(nearest.t, t);
    }
    for (var i = 0u; i < scene.counts.w; i++) {
        let t = thicket_distance(i, origin, direction, nearest.t);
        nearest.id = select(nearest.id, THICKET_HIT | i, t < nearest.t);
        nearest.t = min(nearest.t, t);
    }
    return nearest;
}

// Whether a robot can pass what was hit: strings, and thickets that are not solid.
fn is_passable(hit: Hit) -> bool {
    let kind = hit.id & 0xff00u;
    return kind == CURTAIN_HIT || (kind == THICKET_HIT && scene.thicket_look[hit.id & 0xffu].w < 1.5);
}

// As surface_at, for thin things too: a string is round, an element of a thicket faces anywhere.
fn surface_of(hit: Hit, at: vec3<f32>, direction: vec3<f32>) -> Surface {
    let kind = hit.id & 0xff00u;
    let index = hit.id & 0xffu;
    if kind == CURTAIN_HIT {
        let offset = clamp(string_offset(index, at, direction), -1.0, 1.0);
        let level = normalize(direction.xy + vec2(1.0e-9, 0.0));
        let side = vec2(-level.y, level.x);
        let normal = vec3(-level * sqrt(1.0 - offset * offset) + side * offset, 0.0);
        return Surface(normal, u32(scene.curtain_look[index].w), 1.0);
    }
    if kind == THICKET_HIT {
        let look = scene.thicket_look[index];
        let key = vec3<i32>(floor(at / look.y));
        let bits = hash(hash3(key.x, key.y, index + 133u) ^ bitcast<u32>(key.z));
        // The cosine of a plate that faces anywhere is even in [0, 1]; towards the ray.
        let cosine = 0.05 + 0.95 * unit(bits);
        let helper = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), abs(direction.x) > 0.7);
        let side = normalize(cross(direction, helper));
        let normal = -direction * cosine + side * sqrt(1.0 - cosine * cosine);
        return Surface(normal, u32(look.z), 1.0);
    }
    return surface_at(hit, at, direction);
}
