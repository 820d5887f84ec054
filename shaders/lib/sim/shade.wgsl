// Light that leaves a surface: Fresnel's share of mirror light, patterns, lamps, the projector's speckle. Needs
// lib/sim/scene, lib/sim/random.

// Schlick's approximation of Fresnel's equations.
fn fresnel(at_normal: f32, cosine: f32) -> f32 {
    let x = clamp(1.0 - cosine, 0.0, 1.0);
    let x2 = x * x;
    return at_normal + (1.0 - at_normal) * x2 * x2 * x;
}

// Reflected share of a thin pane: both faces, with what goes to and fro between them.
fn pane_reflectance(one_face: f32) -> f32 {
    return 2.0 * one_face / (1.0 + one_face);
}

// Reflected share where light goes over into another medium, by Fresnel's equations; 1: all of it. `ratio`: index on the
// light's side over that on the other.
fn interface_reflectance(ratio: f32, cosine: f32) -> f32 {
    let squared = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    let beyond = sqrt(max(squared, 0.0));
    let across = (ratio * cosine - beyond) / max(ratio * cosine + beyond, 1.0e-9);
    let along = (cosine - ratio * beyond) / max(cosine + ratio * beyond, 1.0e-9);
    return select(0.5 * (across * across + along * along), 1.0, squared <= 0.0);
}

// Direction of a ray after an interface that it passes, by Snell's law.
fn refracted(direction: vec3<f32>, surface: Surface) -> vec3<f32> {
    let cosine = max(-dot(direction, surface.normal), 0.0);
    let squared = 1.0 - surface.ratio * surface.ratio * (1.0 - cosine * cosine);
    let along = surface.ratio * cosine - sqrt(max(squared, 0.0));
    return normalize(surface.ratio * direction + along * surface.normal);
}

// Whether some material of the scene is crumpled: without one its code is left out.
override crumples: bool = true;

// The surface with its crumples: slopes by smooth noise of the place.
fn crumpled(surface: Surface, at: vec3<f32>, direction: vec3<f32>) -> Surface {
    var bumpy = surface;
    let relief = scene.pattern[surface.material].zw;
    // A loop of one round or none: smooth surfaces wait for nobody.
    for (var k = u32(crumples && relief.x > 0.0); k > 0u; k--) {
        let n = surface.normal;
        let size = abs(n);
        let upright = size.z < max(size.x, size.y);
        let uv = select(at.xy, vec2(select(at.x, at.y, size.x > size.y), at.z), upright) / relief.y;
        let coarse = vec2(value_noise(uv, 41u), value_noise(uv, 43u));
        let fine = vec2(value_noise(uv * 2.7, 47u), value_noise(uv * 2.7, 53u));
        // Of deviation 1: value noise by itself has 0.22.
        let slopes = relief.x * (0.75 * coarse + 0.5 * fine - 0.625) / 0.2;
        let helper = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), size.x > 0.7);
        let side = normalize(cross(n, helper));
        let tilted = normalize(n + slopes.x * side + slopes.y * cross(n, side));
        // What faces away is hidden by what lies before it.
        let towards = -dot(tilted, direction);
        bumpy.normal = normalize(tilted - direction * max(0.05 - towards, 0.0));
    }
    return bumpy;
}

const CHECKER = 1u;
const TILES = 2u;
const PLANKS = 3u;
const CLOUDS = 4u;
const STRIPES = 5u;
const PATCHES = 6.0;

// Share of a pattern's second colour at a point of the surface, in [0, 1]; it fades to its mean
// where a pixel (`footprint_m`) is too coarse for it.
fn pattern_share(kind: u32, scale_m: f32, at: vec3<f32>, normal: vec3<f32>, footprint_m: f32) -> f32 {
    let uv = pattern_place(at, normal, scale_m);
    let cell = floor(uv);
    let share = uv - cell;
    let cell_x = i32(cell.x);
    let cell_y = i32(cell.y);
    var value = 0.5;
    if kind == CHECKER {
        value = f32((cell_x + cell_y) & 1);
    }
    if kind == TILES {
        let joint = share.x < 0.04 || share.y < 0.04;
        value = select(0.35 * unit(hash3(cell_x, cell_y, 11u)), 1.0, joint);
    }
    if kind == PLANKS {
        let row = floor(uv.y * 4.0);
        let plank = floor(uv.x * 0.5 + unit(hash3(i32(row), 3, 5u)));
        let grain = value_noise(vec2(uv.x * 3.0, uv.y * 48.0), 7u);
        value = 0.6 * unit(hash3(i32(plank), i32(row), 13u)) + 0.4 * grain;
    }
    if kind == CLOUDS {
        value = 0.65 * value_noise(uv, 17u) + 0.35 * value_noise(uv * 4.0, 19u);
    }
    if kind == STRIPES {
        value = f32(cell_x & 1);
    }
    let sharpness = clamp(0.5 * scale_m / max(footprint_m, 1.0e-6) - 0.25, 0.0, 1.0);
    return mix(0.5, value, sharpness);
}

// Place on a surface, in periods of its pattern.
fn pattern_place(at: vec3<f32>, normal: vec3<f32>, scale_m: f32) -> vec2<f32> {
    let flat = abs(normal.z) > 0.5;
    let along = select(at.y * normal.x - at.x * normal.y, at.x, flat);
    return vec2(along, select(at.z, at.y, flat)) / scale_m;
}

// Shares of the second colour in each channel of a rectangle: rows of their own height in columns of their own place.
fn patch_shares(uv: vec2<f32>, footprint: f32) -> vec4<f32> {
    let column = floor(uv.x);
    let shift = unit(hash3(i32(column), 5, 61u));
    let place = vec2(column, floor(uv.y * (0.5 + shift) + 7.0 * shift));
    let bits = hash3(i32(place.x), i32(place.y), 67u);
    let shares = vec4(unit(bits), unit(hash(bits)), unit(hash(bits + 1u)), unit(hash(bits + 2u)));
    return mix(vec4(0.5), shares, clamp(0.5 / max(footprint, 1.0e-6) - 0.25, 0.0, 1.0));
}

// Reflectance of a material at a point (r, g, b, infrared).
fn albedo_at(material: u32, at: vec3<f32>, normal: vec3<f32>, footprint_m: f32) -> vec4<f32> {
    let pattern = scene.pattern[material];
    let share = pattern_share(u32(pattern.x), pattern.y, at, normal, footprint_m);
    var shares = vec4(select(0.0, share, pattern.x > 0.0));
    for (var k = u32(pattern.x == PATCHES); k > 0u; k--) {
        shares = patch_shares(pattern_place(at, normal, pattern.y), footprint_m / pattern.y);
    }
    return mix(scene.albedo[material], scene.pattern_albedo[material], shares);
}

// Irradiance over pi that lamp `index` gives to a point, without shadows (r, g, b, infrared).
fn lamp_light(index: u32, at: vec3<f32>, normal: vec3<f32>) -> vec4<f32> {
    let place = scene.light_place[index];
    let towards = place.xyz - at;
    let squared = dot(towards, towards);
    let ray = towards * inverseSqrt(max(squared, 1.0e-9));
    let facing = max(dot(normal, ray), 0.0) * max(-dot(scene.light_normal[index].xyz, ray), 0.0);
    return scene.light_radiance[index] * (place.w * facing / (squared + place.w));
}

// The projector's dots along a ray (x/z, y/z) of its own, mean 1; `cell` is their size in the same unit.
fn speckle(ray: vec2<f32>, cell: f32, contrast: f32, seed: u32) -> f32 {
    let at = ray / cell;
    let dots = value_noise(at, seed) * value_noise(at * 0.83 + 5.3, seed + 1u);
    return 1.0 + contrast * (min(4.0 * dots * dots / 0.36, 6.0) - 1.0);
}
