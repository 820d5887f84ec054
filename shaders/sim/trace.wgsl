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

    var origin = trace_params.origin.xyz;
    var direction = through * depth_per_distance;
    var share = 1.0;
    var travelled_m = 0.0;
    var light = vec4(0.0);
    var depth_m = 0.0;
    var seen = 0u;
    // The mirror side of a pane, kept for later.
    var kept_origin = vec3(0.0);
    var kept_direction = vec3(0.0);
    var kept_share = 0.0;
    // A rough reflection, sampled a ray at a time.
    var lobe_at = vec3(0.0);
    var lobe_in = vec3(0.0);
    var lobe_normal = vec3(0.0);
    var lobe_share = 0.0;
    var lobe_roughness = 0.0;
    var lobe_travelled_m = 0.0;
    var lobe_left = 0u;
    for (var segment = 0u; segment < SEGMENTS && share > 0.0; segment++) {
        let hit = nearest_hit(origin, direction);
        let found = hit.id != NOTHING;
        let at = origin + hit.t * direction;
        let surface = surface_at(hit, at, direction);
        let optics = scene.optics[surface.material];
        travelled_m += hit.t;
        if segment == 0u {
            depth_m = select(0.0, hit.t * depth_per_distance, found);
            seen = select(0u, u32(optics.w), found);
        }
        let cosine = max(-dot(direction, surface.normal), 0.0);
        let one_face = select(0.0, fresnel(optics.x, cosine), optics.x > 0.0);
        let pane = optics.z > 0.0;
        let mirrored = select(one_face, pane_reflectance(one_face), pane);
        let given = reflected_light(surface, at, travelled_m / focal, segment == 0u);
        light += select(0.0, share * (1.0 - mirrored), found && !pane) * given;
        light += select(0.0, share, found && pane) * scene.emission[surface.material];

        // Where the light goes on: through a pane, along the one mirror direction, or into a lobe.
        let reflected = share * mirrored;
        let onward = share * (1.0 - mirrored) * optics.z;
        let bounce = found && reflected > SMALLEST;
        let into_lobe = bounce && !pane && lobe_left == 0u && optics.y > 0.004 && segment < 4u;
        let mirror_direction = reflect(direction, surface.normal);
        let keep = bounce && pane && kept_share == 0.0;
        kept_origin = select(kept_origin, at, keep);
        kept_direction = select(kept_direction, mirror_direction, keep);
        kept_share = select(kept_share, reflected, keep);
        lobe_at = select(lobe_at, at, into_lobe);
        lobe_in = select(lobe_in, direction, into_lobe);
        lobe_normal = select(lobe_normal, surface.normal, into_lobe);
        lobe_share = select(lobe_share, reflected / f32(LOBE_SAMPLES), into_lobe);
        lobe_roughness = select(lobe_roughness, optics.y, into_lobe);
        lobe_travelled_m = select(lobe_travelled_m, travelled_m, into_lobe);
        lobe_left = select(lobe_left, LOBE_SAMPLES, into_lobe);

        let through_pane = found && pane && onward > SMALLEST;
        let mirror_on = bounce && !pane && !into_lobe;
        share = select(select(0.0, reflected, mirror_on), onward, through_pane);
        direction = select(direction, mirror_direction, mirror_on);
        origin = at;
        // This ray ends here: take up what was kept.
        let sample = share == 0.0 && lobe_left > 0u;
        let turn = f32(lobe_left) + unit(hash3(i32(pixel), i32(trace_params.frame_seed), 29u));
        let swing = 6.2831853 * turn / f32(LOBE_SAMPLES);
        let radius = lobe_roughness * sqrt(0.5 * f32(lobe_left & 1u) + 0.5 * fract(turn * 7.0)) * 1.4142136;
        let helper = select(vec3(1.0, 0.0, 0.0), vec3(0.0, 0.0, 1.0), abs(lobe_normal.x) > 0.7);
        let side = normalize(cross(lobe_normal + vec3(0.0, 0.0, 1.0e-9), helper));
        let tilt = radius * (cos(swing) * side + sin(swing) * cross(lobe_normal, side));
        origin = select(origin, lobe_at, sample);
        direction = select(direction, reflect(lobe_in, normalize(lobe_normal + tilt)), sample);
        share = select(share, lobe_share, sample);
        travelled_m = select(travelled_m, lobe_travelled_m, sample);
        lobe_left -= u32(sample);
        let other = share == 0.0 && kept_share > 0.0;
        origin = select(origin, kept_origin, other);
        direction = select(direction, kept_direction, other);
        share = select(share, kept_share, other);
        kept_share = select(kept_share, -1.0, other);
    }
    infrared[pixel] = light.w;
    if left {
        color_light[pixel] = vec2(pack2x16float(min(light.xy, vec2(60000.0))), pack2x16float(vec2(min(light.z, 60000.0), 0.0)));
        color_luminance[pixel] = dot(light.xyz, vec3(0.2126, 0.7152, 0.0722));
        true_depth_m[pixel] = depth_m;
        true_material[pixel] = seen;
    }
}
