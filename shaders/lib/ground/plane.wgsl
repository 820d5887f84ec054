// Planes below a sensor as z = x a + y b + c, (a, b, c); c of no plane is above 0. Needs nothing.

// z = x a + y b + c of n . p = d.
fn slopes_of(plane: vec4<f32>) -> vec3<f32> {
    return vec3(-plane.xy, plane.w) / plane.z;
}

fn normal_of(plane: vec3<f32>) -> vec4<f32> {
    let n = normalize(vec3(-plane.xy, 1.0));
    return vec4(n, plane.z * n.z);
}

fn height_at(plane: vec3<f32>, at: vec2<f32>) -> f32 {
    return dot(plane.xy, at) + plane.z;
}

fn is_plane(plane: vec3<f32>) -> bool {
    return plane.z < 0.0;
}

// Whether two planes differ, in height at a place and in slope, by no more.
fn is_same(a: vec3<f32>, b: vec3<f32>, at: vec2<f32>, most_m: f32, most_slope: f32) -> bool {
    return abs(height_at(a, at) - height_at(b, at)) < most_m && length(a.xy - b.xy) < most_slope;
}

// A plane with what speaks for it.
struct Found {
    plane: vec3<f32>,
    value: f32,         // 0: it is no ground
    level: bool,        // whether it is like one
    area_m2: f32,
    pierced_m2: f32,
    share: f32,
}
