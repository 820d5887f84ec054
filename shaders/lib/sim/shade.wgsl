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

const CHECKER = 1u;
const TILES = 2u;
const PLANKS = 3u;
const CLOUDS = 4u;
const STRIPES = 5u;

// Share of a pattern's second colour at a point of the surface, in [0, 1]; it fades to its mean
// where a pixel (`footprint_m`) is too coarse for it.
fn pattern_share(kind: u32, scale_m: f32, at: vec3<f32>, normal: vec3<f32>, footprint_m: f32) -> f32 {
    let flat = abs(normal.z) > 0.5;
    let along = select(at.y * normal.x - at.x * normal.y, at.x, flat);
    let uv = vec2(along, select(at.z, at.y, flat)) / scale_m;
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

// Reflectance of a material at a point (r, g, b, infrared).
fn albedo_at(material: u32, at: vec3<f32>, normal: vec3<f32>, footprint_m: f32) -> vec4<f32> {
    let pattern = scene.pattern[material];
    let share = pattern_share(u32(pattern.x), pattern.y, at, normal, footprint_m);
    return mix(scene.albedo[material], scene.pattern_albedo[material], select(0.0, share, pattern.x > 0.0));
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
