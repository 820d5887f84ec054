// Traces one camera's rays through the scene: light in the infrared and in colour, true depth, kind of surface.
// spec 1 §8 (glossy floor with Fresnel reflection, lamps, windows, projected speckle).
struct SimTraceParams {
    origin: vec4<f32>,          // camera in the map, metres; w: radius of its field where the speckle ends, as x/z
    right: vec4<f32>,           // the optical frame's x in the map; w: focal length, pixels
    down: vec4<f32>,            // y; w: principal point x, pixels
    forward: vec4<f32>,         // z; w: principal point y, pixels
    projector: vec4<f32>,       // in the map, metres; w: strength
    speckle: vec4<f32>,         // dot size as x/z, contrast, unused
    width: u32,
    height: u32,
    speckle_seed: u32,
    frame_seed: u32,            // differs by frame and camera
}

@group(0) @binding(0) var<uniform> trace_params: SimTraceParams;
@group(0) @binding(1) var<uniform> scene: SimScene;
@group(0) @binding(2) var<storage, read_write> infrared: array<f32>;
@group(0) @binding(3) var<storage, read_write> color_light: array<vec2<u32>>;   // r, g and b, luminance as halves
@group(0) @binding(4) var<storage, read_write> color_luminance: array<f32>;
@group(0) @binding(5) var<storage, read_write> true_depth_m: array<f32>;
@group(0) @binding(6) var<storage, read_write> true_material: array<u32>;

// Whether this is the left camera, which colour and truth belong to.
override left: bool = true;

const SEGMENTS = 10u;           // rays a pixel may spend
const LOBE_SAMPLES = 2u;        // of them for the blur of a rough reflection
const SMALLEST = 0.004;         // shares of light below this are not followed

// What a surface sends towards the camera of the light that meets it. Of the lamps the strongest at the point casts
// shadows.
fn reflected_light(surface: Surface, at: vec3<f32>, footprint_m: f32, shadows: bool) -> vec4<f32> {
    let normal = surface.normal;
    var light = scene.ambient * (0.85 + 0.15 * normal.z);
    var strongest = vec4(0.0);
    var strongest_at = at + normal;
    for (var i = 0u; i < scene.counts.x; i++) {
        let lamp = lamp_light(i, at, normal);
        let stronger = lamp.w + lamp.y > strongest.w + strongest.y;
        strongest = select(strongest, lamp, stronger);
        strongest_at = select(strongest_at, scene.light_place[i].xyz, stronger);
        light += lamp;
    }
    // A loop of one round or none: a group of pixels without a shadow ray waits for nobody.
    let start = at + normal * 2.0e-3;
    let reach = length(strongest_at - start);
    for (var k = u32(shadows && strongest.w + strongest.y > 0.0); k > 0u; k--) {
        let shadowed = is_shadowed(start, (strongest_at - start) / reach, reach - 0.05);
        light -= select(vec4(0.0), strongest, shadowed);
    }
    light += sunlight(at, normal);
    light.w += projected_light(at, normal);
    return albedo_at(surface.material, at, normal, footprint_m) * light + scene.emission[surface.material];
}

fn projected_light(at: vec3<f32>, normal: vec3<f32>) -> f32 {
    let offset = at - trace_params.projector.xyz;
    let depth = dot(offset, trace_params.forward.xyz);
    let squared = max(dot(offset, offset), 0.04);
    let facing = max(-dot(offset, normal), 0.0) * inverseSqrt(squared);
    let ray = vec2(dot(offset, trace_params.right.xyz), dot(offset, trace_params.down.xyz)) / max(depth, 1.0e-3);
    let shape = trace_params.speckle;
    let pattern = speckle(ray, shape.x, shape.y, trace_params.speckle_seed);
    let lit = depth > 0.05 && max(abs(ray.x), abs(ray.y)) < trace_params.origin.w;
    return select(0.0, trace_params.projector.w * pattern * facing / squared, lit);
}

// A pixel's rays: the one under way, and those that are still to come.
struct Path {
    origin: vec3<f32>,
    direction: vec3<f32>,
    share: f32,                 // of what it finds that reaches the camera; 0: none is left
    travelled_m: f32,
    light: vec4<f32>,           // found so far (r, g, b, infrared)
    met_m: f32,                 // length of the last ray, 0 where it met nothing
    met_kind: f32,              // and the kind of surface there
    // The mirror side of a pane, for later; share -1: had its turn.
    kept_origin: vec3<f32>,
    kept_direction: vec3<f32>,
    kept_share: f32,
    // A rough reflection, sampled a ray at a time.
    lobe_at: vec3<f32>,
    lobe_in: vec3<f32>,
    lobe_normal: vec3<f32>,
    lobe_share: f32,
    lobe_roughness: f32,
    lobe_travelled_m: f32,
    lobe_left: u32,
}

// Follows one ray: takes up the light where it ends, and prepares the next.
fn followed(path: Path, pixel: u32, first: bool) -> Path {
    var p = path;
    let hit = nearest_thin(nearest_hit(p.origin, p.direction), p.origin, p.direction);
    let found = hit.id != NOTHING;
    let at = p.origin + hit.t * p.direction;
    let surface = crumpled(surface_of(hit, at, p.direction), at, p.direction);
    let optics = scene.optics[surface.material];
    p.travelled_m += hit.t;
    p.met_m = select(0.0, hit.t, found);
    p.met_kind = select(0.0, optics.w, found);
    let cosine = max(-dot(p.direction, surface.normal), 0.0);
    let one_face = select(0.0, fresnel(optics.x, cosine), optics.x > 0.0);
    let pane = optics.z > 0.0;
    let bends = pane && surface.ratio != 1.0;
    let thin = select(one_face, pane_reflectance(one_face), pane);
    let mirrored = select(thin, interface_reflectance(surface.ratio, cosine), bends);
    let total = bends && mirrored >= 1.0;
    let given = reflected_light(surface, at, p.travelled_m / trace_params.right.w, first);
    p.light += select(0.0, p.share * (1.0 - mirrored), found && !pane) * given;

    // Where the light goes on: through something clear, along the one mirror direction, or into a lobe.
    let reflected = p.share * mirrored;
    let onward = p.share * (1.0 - mirrored) * optics.z;
    let bounce = found && reflected > SMALLEST;
    let into_lobe = bounce && !pane && p.lobe_left == 0u && optics.y > 0.004 && p.lobe_share == 0.0;
    let mirror_direction = reflect(p.direction, surface.normal);
    let keep = bounce && pane && !total && p.kept_share == 0.0;
    p.kept_origin = select(p.kept_origin, at, keep);
    p.kept_direction = select(p.kept_direction, mirror_direction, keep);
    p.kept_share = select(p.kept_share, reflected, keep);
    p.lobe_at = select(p.lobe_at, at, into_lobe);
    p.lobe_in = select(p.lobe_in, p.direction, into_lobe);
    p.lobe_normal = select(p.lobe_normal, surface.normal, into_lobe);
    p.lobe_share = select(p.lobe_share, reflected / f32(LOBE_SAMPLES), into_lobe);
    p.lobe_roughness = select(p.lobe_roughness, optics.y, into_lobe);
    p.lobe_travelled_m = select(p.lobe_travelled_m, p.travelled_m, into_lobe);
    p.lobe_left = select(p.lobe_left, LOBE_SAMPLES, into_lobe);

    let through_pane = found && pane && onward > SMALLEST;
    let mirror_on = bounce && (!pane || total) && !into_lobe;
    p.share = select(select(0.0, reflected, mirror_on), onward, through_pane);
    p.direction = select(p.direction, mirror_direction, mirror_on);
    p.direction = select(p.direction, refracted(path.direction, surface), through_pane && bends);
    p.origin = at;
    return with_next(p, pixel);
}

// Where a ray has ended: takes up what was kept.
fn with_next(path: Path, pixel: u32) -> Path {
    var p = path;
    let sample = p.share == 0.0 && p.lobe_left > 0u;
    let turn = f32(p.lobe_left) + unit(hash3(i32(pixel), i32(trace_params.frame_seed), 29u));
    let swing = 6.2831853 * turn / f32(LOBE_SAMPLES);
    let radius = p.lobe_roughness * sqrt(0.5 * f32(p.lobe_left & 1u) + 0.5 * fract(turn * 7.0)) * 1.4142136;
    let helper = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), abs(p.lobe_normal.x) > 0.7);
    let side = normalize(cross(p.lobe_normal + vec3(0.0, 0.0, 1.0e-9), helper));
    let tilt = radius * (cos(swing) * side + sin(swing) * cross(p.lobe_normal, side));
    p.origin = select(p.origin, p.lobe_at, sample);
    p.direction = select(p.direction, reflect(p.lobe_in, normalize(p.lobe_normal + tilt)), sample);
    p.share = select(p.share, p.lobe_share, sample);
    p.travelled_m = select(p.travelled_m, p.lobe_travelled_m, sample);
    p.lobe_left -= u32(sample);
    let other = p.share == 0.0 && p.kept_share > 0.0;
    p.origin = select(p.origin, p.kept_origin, other);
    p.direction = select(p.direction, p.kept_direction, other);
    p.share = select(p.share, p.kept_share, other);
    p.kept_share = select(p.kept_share, -1.0, other);
    return p;
}

@compute @workgroup_size(16, 4)
fn trace(@builtin(global_invocation_id) id: vec3<u32>) {
    let width = trace_params.width;
    if id.x >= width || id.y >= trace_params.height {
        return;
    }
    let pixel = id.y * width + id.x;
    let focal = trace_params.right.w;
    let ray = (vec2<f32>(id.xy) - vec2(trace_params.down.w, trace_params.forward.w)) / focal;
    let through = trace_params.right.xyz * ray.x + trace_params.down.xyz * ray.y + trace_params.forward.xyz;
    let depth_per_distance = inverseSqrt(dot(through, through));
    var path: Path;
    path.origin = trace_params.origin.xyz;
    path.direction = through * depth_per_distance;
    path.share = 1.0;
    var depth_m = 0.0;
    var seen = 0u;
    for (var segment = 0u; segment < SEGMENTS; segment++) {
        if path.share <= 0.0 {
            break;
        }
        // The first ray alone casts shadow rays, and is what the truth tells of.
        let first = segment == 0u;
        path = followed(path, pixel, first);
        depth_m = select(depth_m, path.met_m * depth_per_distance, first);
        seen = select(seen, u32(path.met_kind), first);
    }
    let light = path.light;
    infrared[pixel] = light.w;
    if left {
        let bounded = min(light.xyz, vec3(60000.0));
        color_light[pixel] = vec2(pack2x16float(bounded.xy), pack2x16float(vec2(bounded.z, 0.0)));
        color_luminance[pixel] = dot(light.xyz, vec3(0.2126, 0.7152, 0.0722));
        true_depth_m[pixel] = depth_m;
        true_material[pixel] = seen;
    }
}
