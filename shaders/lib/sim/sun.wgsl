// Sunlight: whether it reaches a place through windows, panes and clear things. Needs lib/sim/scene, lib/sim/shade.
// Whether the scene has a sun: without one its code is left out.
override sunny: bool = true;

const SUN_PANES = 6u;           // clear surfaces that it may pass
const WINDOW_KIND = 8.0;
const SKY_M = 1.0e7;            // a ceiling above this is the open sky

// Share of the sun's light at a place, 0 in shadow: a clear surface lets through what it does not mirror.
fn sunlight_share(start: vec3<f32>) -> f32 {
    let sun = scene.sun_direction.xyz;
    var place = start;
    var share = 1.0;
    for (var pane = 0u; pane < SUN_PANES; pane++) {
        let hit = nearest_hit(place, sun);
        place += hit.t * sun;
        let surface = surface_at(hit, place, sun);
        let optics = scene.optics[surface.material];
        if optics.z == 0.0 {
            let sky = hit.id == CEILING_HIT && scene.size.x > SKY_M;
            return select(0.0, share, sky || optics.w == WINDOW_KIND);
        }
        share *= optics.z * (1.0 - pane_reflectance(fresnel(optics.x, max(-dot(sun, surface.normal), 0.0))));
    }
    return 0.0;
}

// What the sun gives to a point, as a lamp does (r, g, b, infrared).
fn sunlight(at: vec3<f32>, normal: vec3<f32>) -> vec4<f32> {
    let facing = dot(normal, scene.sun_direction.xyz);
    var light = vec4(0.0);
    // A loop of one round or none, as for shadows.
    for (var k = u32(sunny && scene.sun_direction.w > 0.0 && facing > 0.0); k > 0u; k--) {
        light = scene.sun_radiance * (facing * sunlight_share(at + normal * 2.0e-3));
    }
    return light;
}
