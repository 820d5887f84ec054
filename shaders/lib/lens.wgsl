// Whether the lens is a fisheye (equidistant), else polynomial.
override fisheye: bool = false;

// Distortion of an ideal ray (x/z, y/z): rational_polynomial, of which plumb_bob is a case, or equidistant.
// a = (k1, k2, p1, p2), b = (k3, k4, k5, k6), in ROS's order; of a fisheye a = (k1, k2, k3, k4).
fn distort(ideal: vec2<f32>, a: vec4<f32>, b: vec4<f32>) -> vec2<f32> {
    if fisheye {
        return distort_fisheye(ideal, a);
    }
    return distort_polynomial(ideal, a, b);
}

fn distort_fisheye(ideal: vec2<f32>, k: vec4<f32>) -> vec2<f32> {
    let r = length(ideal);
    let angle = atan(r);
    let a2 = angle * angle;
    let bent = angle * (1.0 + a2 * (k.x + a2 * (k.y + a2 * (k.z + a2 * k.w))));
    return ideal * select(1.0, bent / max(r, 1.0e-9), r > 1.0e-6);
}

fn distort_polynomial(ideal: vec2<f32>, a: vec4<f32>, b: vec4<f32>) -> vec2<f32> {
    let r2 = dot(ideal, ideal);
    let radial = (1.0 + r2 * (a.x + r2 * (a.y + r2 * b.x))) / (1.0 + r2 * (b.y + r2 * (b.z + r2 * b.w)));
    let cross = 2.0 * ideal.x * ideal.y;
    return ideal * radial + vec2(
        a.z * cross + a.w * (r2 + 2.0 * ideal.x * ideal.x),
        a.z * (r2 + 2.0 * ideal.y * ideal.y) + a.w * cross,
    );
}
