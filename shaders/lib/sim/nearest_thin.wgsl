// The nearest of a scene's thin things along a ray, out of its tables. As of lib/sim/solids, the host may write this out for
// a scene. Needs lib/sim/scene, lib/sim/thin.

// The nearer of a hit and what thin things a ray meets before it.
fn nearest_thin(before: Hit, origin: vec3<f32>, direction: vec3<f32>) -> Hit {
    var hit = before;
    for (var i = 0u; i < scene.counts.z; i++) {
        hit = nearer(hit, curtain_distance(curtain_of(i), origin, direction), CURTAIN_HIT | i);
    }
    for (var i = 0u; i < scene.counts.w; i++) {
        let thicket = Thicket(i, scene.thicket_center[i], scene.thicket_half[i], scene.thicket_look[i]);
        hit = nearer(hit, thicket_distance(thicket, origin, direction, hit.t), THICKET_HIT | i);
    }
    return hit;
}
