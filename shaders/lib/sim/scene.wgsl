// A scene as the ray tracer holds it, and where rays meet it: rectangles, upright boxes and cylinders, vessels,
// floor and ceiling. Clear boxes and vessels are met from inside too. Needs lib/sim/solids, or what the host writes in its place.
const QUADS = 64u;
const BOXES = 48u;
const CYLINDERS = 16u;
const LIGHTS = 16u;
const MATERIALS = 32u;
const CURTAINS = 8u;
const THICKETS = 24u;
const FRUSTUMS = 56u;

struct SimScene {
    counts: vec4<u32>,          // lights, clusters, curtains, thickets
    room: vec4<u32>,            // material of floor and ceiling, unused
    ambient: vec4<f32>,         // r, g, b, infrared
    size: vec4<f32>,            // ceiling height in metres; unused
    quad_plane: array<vec4<f32>, 64>,       // unit normal, its distance from the origin
    quad_u: array<vec4<f32>, 64>,           // along the width: dot(xyz, p) - w is in [-1, 1]
    quad_v: array<vec4<f32>, 64>,           // along the height
    quad_material: array<vec4<u32>, 64>,    // material, unused
    box_center: array<vec4<f32>, 48>,       // xyz, cosine of the yaw
    box_half: array<vec4<f32>, 48>,         // half extents, sine of the yaw
    box_material: array<vec4<u32>, 48>,     // material, 1: it is clear, bits of its refractive index
    cylinder_axis: array<vec4<f32>, 16>,    // x, y, radius, unused
    cylinder_span: array<vec4<f32>, 16>,    // bottom, top, unused
    cylinder_material: array<vec4<u32>, 16>,
    cluster_low: array<vec4<f32>, 48>,      // least corner of a group of solids that lie together
    cluster_high: array<vec4<f32>, 48>,     // its greatest corner
    // First in bits 0 to 7, end in 8 to 15: rectangles and boxes (16 to 23: end of those that cast shadows), cylinders,
    // a vessel's cones (16 to 23: end of the discs behind them; 24: it casts a shadow).
    cluster_range: array<vec4<u32>, 48>,
    light_place: array<vec4<f32>, 16>,      // centre, area / pi
    light_normal: array<vec4<f32>, 16>,     // unit normal, unused
    light_radiance: array<vec4<f32>, 16>,   // r, g, b, infrared
    albedo: array<vec4<f32>, 32>,           // r, g, b, infrared
    pattern_albedo: array<vec4<f32>, 32>,   // the pattern's other colour
    pattern: array<vec4<f32>, 32>,          // kind, scale in metres; deviation of crumples, their size
    optics: array<vec4<f32>, 32>,           // reflectance at normal incidence, roughness, transmission, kind
    emission: array<vec4<f32>, 32>,         // r, g, b, infrared
    curtain_plane: array<vec4<f32>, 8>,     // as of rectangles
    curtain_u: array<vec4<f32>, 8>,
    curtain_v: array<vec4<f32>, 8>,
    curtain_look: array<vec4<f32>, 8>,      // spacing and width of strings, half the width, material
    thicket_center: array<vec4<f32>, 24>,   // xyz, cosine of the yaw
    thicket_half: array<vec4<f32>, 24>,     // half extents, sine of the yaw
    thicket_look: array<vec4<f32>, 24>,     // extinction 1/m, width of elements, material, 1: an ellipsoid, + 2: solid
    frustum_axis: array<vec4<f32>, 56>,     // x, y, radius at the lower and upper end (of a disc: inner and outer)
    // Bits of the heights of its ends, refractive indices of the body and around it in 1/16384, material + 256 where the
    // body lies away from the axis (of a disc: above).
    frustum_look: array<vec4<u32>, 56>,
    sun_direction: vec4<f32>,               // towards it; w: 1 where it shines
    sun_radiance: vec4<f32>,                // r, g, b, infrared, of a white surface that faces it
}

// Whether the scene has vessels: without them their code is left out.
override vessels: bool = true;

// What a ray meets: distance along it (FAR where nothing), and kind of surface in bits 8 and up with its index.
struct Hit {
    t: f32,
    id: u32,
}

const FAR = 1.0e9;
const NOTHING = 0u;
const FLOOR_HIT = 0x100u;
const CEILING_HIT = 0x200u;
const QUAD_HIT = 0x300u;
const BOX_HIT = 0x400u;
const CYLINDER_HIT = 0x500u;
const FRUSTUM_HIT = 0x800u;

// Nearer hits belong to the surface that the ray starts on.
const NEAREST = 1.0e-4;

// Keeps a divisor away from 0.
fn away_from_zero(value: f32) -> f32 {
    return select(value, select(-1.0e-9, 1.0e-9, value >= 0.0), abs(value) < 1.0e-9);
}

fn quad_distance(plane: vec4<f32>, u: vec4<f32>, v: vec4<f32>, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let t = (plane.w - dot(plane.xyz, origin)) / away_from_zero(dot(plane.xyz, direction));
    let at = origin + t * direction;
    let inside = abs(dot(u.xyz, at) - u.w) <= 1.0 && abs(dot(v.xyz, at) - v.w) <= 1.0;
    return select(FAR, t, inside && t > NEAREST);
}

// A direction or offset in a box's own axes.
fn turned(v: vec3<f32>, cosine: f32, sine: f32) -> vec3<f32> {
    return vec3(cosine * v.x + sine * v.y, cosine * v.y - sine * v.x, v.z);
}

// Clear boxes are met from inside too.
fn box_distance(center: vec4<f32>, half: vec4<f32>, clear: bool, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let o = turned(origin - center.xyz, center.w, half.w);
    let d = turned(direction, center.w, half.w);
    let inverse = inverse_of(d);
    let middle = -o * inverse;
    let reach = half.xyz * abs(inverse);
    let first = middle - reach;
    let last = middle + reach;
    let near = max(first.x, max(first.y, first.z));
    let far = min(last.x, min(last.y, last.z));
    let t = select(near, far, clear && near <= NEAREST);
    return select(FAR, t, near <= far && t > NEAREST);
}

fn cylinder_distance(axis: vec4<f32>, span: vec4<f32>, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let o = origin.xy - axis.xy;
    let a = max(dot(direction.xy, direction.xy), 1.0e-12);
    let b = dot(o, direction.xy);
    // The discriminant by the distance of closest approach, which keeps its digits far away.
    let closest = o - (b / a) * direction.xy;
    let under_root = a * (axis.z * axis.z - dot(closest, closest));
    let root = sqrt(max(under_root, 0.0));
    let inverse_z = 1.0 / away_from_zero(direction.z);
    let bottom = (span.x - origin.z) * inverse_z;
    let top = (span.y - origin.z) * inverse_z;
    let near = max((-b - root) / a, min(bottom, top));
    let far = min((-b + root) / a, max(bottom, top));
    return select(FAR, near, under_root > 0.0 && near <= far && near > NEAREST);
}

// Heights of a frustum's ends.
fn frustum_span(index: u32) -> vec2<f32> {
    return bitcast<vec2<f32>>(scene.frustum_look[index].xy);
}

// Two roots of a quadratic that lies on the ray, of which the nearer one ahead in the span counts.
fn cone_distance(index: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let axis = scene.frustum_axis[index];       // x, y, radius at the lower and upper end
    let span = frustum_span(index);
    let slope = (axis.w - axis.z) / (span.y - span.x);
    let d = direction;
    // From the closest approach to the axis, where no digits are lost.
    let level = max(dot(d.xy, d.xy), 1.0e-12);
    let start = clamp(-dot(origin.xy - axis.xy, d.xy) / level, -1.0e3, 1.0e3);
    let o = origin + start * d - vec3(axis.xy, 0.0);
    let radius = axis.z + slope * (o.z - span.x);
    let a = dot(d.xy, d.xy) - slope * slope * d.z * d.z;
    let b = dot(o.xy, d.xy) - slope * radius * d.z;
    let c = dot(o.xy, o.xy) - radius * radius;
    let under_root = b * b - a * c;
    let root = sqrt(max(under_root, 0.0));
    let q = -(b + select(-root, root, b >= 0.0));
    let first = cone_place(start + q / away_from_zero(a), origin.z, d.z, span);
    let second = cone_place(start + c / away_from_zero(q), origin.z, d.z, span);
    return select(FAR, min(first, second), under_root > 0.0);
}

// A place along a ray, if it lies ahead and between two heights.
fn cone_place(t: f32, origin_z: f32, direction_z: f32, span: vec2<f32>) -> f32 {
    let height = origin_z + t * direction_z;
    // Neighbours overlap by a rounding error, so that nothing slips through.
    let inside = height >= span.x - 1.0e-6 && height <= span.y + 1.0e-6;
    return select(FAR, t, inside && t > NEAREST);
}

fn disc_distance(index: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    let axis = scene.frustum_axis[index];       // x, y, inner and outer radius
    let t = (frustum_span(index).x - origin.z) / away_from_zero(direction.z);
    let radius = length(origin.xy + t * direction.xy - axis.xy);
    return select(FAR, t, radius >= axis.z && radius <= axis.w && t > NEAREST);
}

fn nearer(hit: Hit, t: f32, id: u32) -> Hit {
    return Hit(min(hit.t, t), select(hit.id, id, t < hit.t));
}

// The nearer of a hit and the surfaces of a vessel; `range` is the fourth of its cluster's.
fn nearest_of_vessel(hit: Hit, range: u32, origin: vec3<f32>, direction: vec3<f32>) -> Hit {
    var nearest = hit;
    for (var i = range & 255u; i < ((range >> 8u) & 255u); i++) {
        nearest = nearer(nearest, cone_distance(i, origin, direction), FRUSTUM_HIT | i);
    }
    for (var i = (range >> 8u) & 255u; i < ((range >> 16u) & 255u); i++) {
        nearest = nearer(nearest, disc_distance(i, origin, direction), FRUSTUM_HIT | i);
    }
    return nearest;
}

// The nearest surface along a ray.
fn nearest_hit(origin: vec3<f32>, direction: vec3<f32>) -> Hit {
    var hit = Hit(FAR, NOTHING);
    let level = select(0.0, scene.size.x, direction.z > 0.0);
    let vertical = (level - origin.z) / away_from_zero(direction.z);
    if vertical > NEAREST {
        hit = Hit(vertical, select(FLOOR_HIT, CEILING_HIT, direction.z > 0.0));
    }
    return nearest_solid(hit, origin, direction, inverse_of(direction));
}

fn inverse_of(direction: vec3<f32>) -> vec3<f32> {
    return 1.0 / vec3(away_from_zero(direction.x), away_from_zero(direction.y), away_from_zero(direction.z));
}

// Whether a ray comes through a group's bounds before `reach`; `inverse`: of its direction.
fn meets_bounds(low: vec3<f32>, high: vec3<f32>, origin: vec3<f32>, inverse: vec3<f32>, reach: f32) -> bool {
    let a = (low - origin) * inverse;
    let b = (high - origin) * inverse;
    let first = min(a, b);
    let last = max(a, b);
    let near = max(first.x, max(first.y, first.z));
    let far = min(last.x, min(last.y, last.z));
    return near <= far && far > 0.0 && near < reach;
}

// Whether something stands within `reach` along a ray that casts shadows: anything but glass and lights.
fn is_shadowed(origin: vec3<f32>, direction: vec3<f32>, reach: f32) -> bool {
    return nearest_shadow(origin, direction, inverse_of(direction), reach) < reach;
}

// Out of the body that a vessel's surface encloses.
fn frustum_normal(index: u32, at: vec3<f32>) -> vec3<f32> {
    let axis = scene.frustum_axis[index];
    let span = frustum_span(index);
    let facing = select(1.0, -1.0, scene.frustum_look[index].w > 0xffu);
    let is_disc = span.x == span.y;
    let slope = (axis.w - axis.z) / select(span.y - span.x, 1.0, is_disc);
    let out = at.xy - axis.xy;
    let side = normalize(vec3(out / max(length(out), 1.0e-9), -slope));
    return facing * select(side, vec3(0.0, 0.0, 1.0), is_disc);
}

// Unit normal towards where the ray comes from, the material, and the refractive index on the ray's side over that on the
// other (1: the ray goes straight on, if at all).
struct Surface {
    normal: vec3<f32>,
    material: u32,
    ratio: f32,
}

fn surface_at(hit: Hit, at: vec3<f32>, direction: vec3<f32>) -> Surface {
    let kind = hit.id & 0xff00u;
    let index = hit.id & 0xffu;
    var normal = vec3(0.0, 0.0, select(1.0, -1.0, kind == CEILING_HIT));
    var material = select(scene.room.x, scene.room.y, kind == CEILING_HIT);
    var indices = vec2(1.0);    // of the body and around it
    if kind == QUAD_HIT {
        normal = scene.quad_plane[index].xyz;
        material = scene.quad_material[index].x;
    }
    if kind == BOX_HIT {
        let center = scene.box_center[index];
        let half = scene.box_half[index];
        let local = turned(at - center.xyz, center.w, half.w) / half.xyz;
        let size = abs(local);
        let x_face = size.x >= size.y && size.x >= size.z;
        let y_face = !x_face && size.y >= size.z;
        let face = vec3(f32(x_face), f32(y_face), f32(!x_face && !y_face)) * sign(local);
        normal = turned(face, center.w, -half.w);
        material = scene.box_material[index].x;
        indices.x = bitcast<f32>(scene.box_material[index].z);
    }
    if kind == CYLINDER_HIT {
        let axis = scene.cylinder_axis[index];
        let span = scene.cylinder_span[index];
        let out = (at.xy - axis.xy) / axis.z;
        let height = (at.z - 0.5 * (span.x + span.y)) / (0.5 * (span.y - span.x));
        // Of two faces that meet in a rim the one nearer to the point.
        let on_cap = (1.0 - abs(height)) * (span.y - span.x) < 2.0 * (1.0 - length(out)) * axis.z;
        normal = select(vec3(out / max(length(out), 1.0e-9), 0.0), vec3(0.0, 0.0, sign(height)), on_cap);
        material = scene.cylinder_material[index].x;
    }
    if kind == FRUSTUM_HIT {
        normal = frustum_normal(index, at);
        material = scene.frustum_look[index].w & 0xffu;
        let packed = scene.frustum_look[index].z;
        indices = vec2(f32(packed & 0xffffu), f32(packed >> 16u)) / 16384.0;
    }
    let leaves = dot(normal, direction) > 0.0;
    let ratio = select(indices.y / indices.x, indices.x / indices.y, leaves);
    return Surface(select(normal, -normal, leaves), material, ratio);
}
