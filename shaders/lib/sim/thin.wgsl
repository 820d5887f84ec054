// Things that a ray passes between: thickets of thin elements, curtains of strings. Needs lib/sim/scene, lib/sim/random,
// lib/sim/nearest_thin or what the host writes in its place.
// spec 6 §1 (thickets by distance travelled, strings by their spacing).
const THICKET_HIT = 0x600u;
const CURTAIN_HIT = 0x700u;

// Where the random element of a ray is looked up, metres behind the place where the ray comes in.
const LOOK_UP_M = 0.5;

// A thicket as the scene's tables have it.
struct Thicket {
    index: u32,
    center: vec4<f32>,
    half: vec4<f32>,
    look: vec4<f32>,
}

// A curtain as they have it.
struct Curtain {
    plane: vec4<f32>,
    u: vec4<f32>,
    v: vec4<f32>,
    look: vec4<f32>,
}

// Where a ray enters and leaves a thicket's bounds: a box, or the ellipsoid in it.
fn thicket_span(thicket: Thicket, origin: vec3<f32>, direction: vec3<f32>) -> vec2<f32> {
    let center = thicket.center;
    let half = thicket.half;
    let o = turned(origin - center.xyz, center.w, half.w) / half.xyz;
    let d = turned(direction, center.w, half.w) / half.xyz;
    if fract(0.5 * thicket.look.w) > 0.25 {
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
fn thicket_distance(thicket: Thicket, origin: vec3<f32>, direction: vec3<f32>, reach: f32) -> f32 {
    let look = thicket.look;       // extinction 1/m, element width, material, shape
    let span = thicket_span(thicket, origin, direction);
    let start = max(span.x, 0.0);
    let end = min(span.y, reach);
    var t = FAR;
    // A loop of one round or none: a group of rays that all pass by goes on at once.
    for (var k = u32(start < end && look.x > 0.0); k > 0u; k--) {
        let key = vec3<i32>(floor((origin + (start + LOOK_UP_M) * direction) / look.y));
        let chance = unit(hash(hash3(key.x, key.y, thicket.index + 71u) ^ bitcast<u32>(key.z)));
        let element = start - log(max(1.0 - chance, 1.0e-7)) / look.x;
        t = select(FAR, element, element > NEAREST && element < end);
    }
    return t;
}

// How far off the middle of a curtain's string a ray passes, as a share of the string's radius; above 1: between two.
fn string_offset(curtain: Curtain, at: vec3<f32>, direction: vec3<f32>) -> f32 {
    let look = curtain.look;       // spacing, string width, half the curtain's width, material
    let u = curtain.u;
    let along = (dot(u.xyz, at) - u.w) * look.z / look.x;
    let level = normalize(direction.xy + vec2(1.0e-9, 0.0));
    let facing = abs(dot(curtain.plane.xy, level));
    return (fract(along) - 0.5) * look.x * facing / (0.5 * look.y);
}

fn curtain_distance(curtain: Curtain, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let plane = curtain.plane;
    let u = curtain.u;
    let v = curtain.v;
    let t = (plane.w - dot(plane.xyz, origin)) / away_from_zero(dot(plane.xyz, direction));
    let at = origin + t * direction;
    let inside = abs(dot(u.xyz, at) - u.w) <= 1.0 && abs(dot(v.xyz, at) - v.w) <= 1.0;
    let on_string = abs(string_offset(curtain, at, direction)) < 1.0;
    return select(FAR, t, inside && on_string && t > NEAREST);
}

fn curtain_of(i: u32) -> Curtain {
    return Curtain(scene.curtain_plane[i], scene.curtain_u[i], scene.curtain_v[i], scene.curtain_look[i]);
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
        let offset = clamp(string_offset(curtain_of(index), at, direction), -1.0, 1.0);
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
