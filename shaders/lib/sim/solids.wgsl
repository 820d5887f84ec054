// The nearest of a scene's solids along a ray, out of its tables. Where a scene is looked at often, the host writes these
// two functions out for it, with its numbers in them (src/sim/written.rs): they give the same bits. Needs lib/sim/scene.

// The nearer of a hit and the solids; `inverse`: of the ray's direction.
fn nearest_solid(before: Hit, origin: vec3<f32>, direction: vec3<f32>, inverse: vec3<f32>) -> Hit {
    var hit = before;
    for (var c = 0u; c < scene.counts.y; c++) {
        // A loop of one round or none: a group of rays that all pass by goes on at once.
        for (var k = u32(meets_cluster(c, origin, inverse, hit.t)); k > 0u; k--) {
            let range = scene.cluster_range[c];
            for (var i = range.x & 255u; i < ((range.x >> 8u) & 255u); i++) {
                hit = nearer(hit, quad_of(i, origin, direction), QUAD_HIT | i);
            }
            for (var i = range.y & 255u; i < ((range.y >> 8u) & 255u); i++) {
                hit = nearer(hit, box_of(i, origin, direction), BOX_HIT | i);
            }
            for (var i = range.z & 255u; i < (range.z >> 8u); i++) {
                hit = nearer(hit, cylinder_of(i, origin, direction), CYLINDER_HIT | i);
            }
            if vessels {
                hit = nearest_of_vessel(hit, range.w, origin, direction);
            }
        }
    }
    return hit;
}

// Distance to the nearest solid that casts a shadow, where one is nearer than `reach`.
fn nearest_shadow(origin: vec3<f32>, direction: vec3<f32>, inverse: vec3<f32>, reach: f32) -> f32 {
    var nearest = FAR;
    for (var c = 0u; c < scene.counts.y; c++) {
        for (var k = u32(meets_cluster(c, origin, inverse, min(nearest, reach))); k > 0u; k--) {
            let range = scene.cluster_range[c];
            for (var i = range.x & 255u; i < (range.x >> 16u); i++) {
                nearest = min(nearest, quad_of(i, origin, direction));
            }
            for (var i = range.y & 255u; i < (range.y >> 16u); i++) {
                nearest = min(nearest, box_of(i, origin, direction));
            }
            for (var i = range.z & 255u; i < (range.z >> 8u); i++) {
                nearest = min(nearest, cylinder_of(i, origin, direction));
            }
            if vessels {
                let opaque_vessel = select(0u, range.w, (range.w >> 24u) > 0u);
                nearest = nearest_of_vessel(Hit(nearest, NOTHING), opaque_vessel, origin, direction).t;
            }
        }
    }
    return nearest;
}

fn meets_cluster(c: u32, origin: vec3<f32>, inverse: vec3<f32>, reach: f32) -> bool {
    return meets_bounds(scene.cluster_low[c].xyz, scene.cluster_high[c].xyz, origin, inverse, reach);
}

fn quad_of(i: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    return quad_distance(scene.quad_plane[i], scene.quad_u[i], scene.quad_v[i], origin, direction);
}

fn box_of(i: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    return box_distance(scene.box_center[i], scene.box_half[i], scene.box_material[i].y > 0u, origin, direction);
}

fn cylinder_of(i: u32, origin: vec3<f32>, direction: vec3<f32>) -> f32 {
    return cylinder_distance(scene.cylinder_axis[i], scene.cylinder_span[i], origin, direction);
}
