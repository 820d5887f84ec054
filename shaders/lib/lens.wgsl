// Distortion of an ideal ray (x/z, y/z): rational_polynomial, of which plumb_bob is a case.
// a = (k1, k2, p1, p2), b = (k3, k4, k5, k6), in ROS's order.
fn distort(ideal: vec2<f32>, a: vec4<f32>, b: vec4<f32>) -> vec2<f32> {
    let r2 = dot(ideal, ideal);
    let radial = (1.0 + r2 * (a.x + r2 * (a.y + r2 * b.x))) / (1.0 + r2 * (b.y + r2 * (b.z + r2 * b.w)));
    let cross = 2.0 * ideal.x * ideal.y;
    return ideal * radial + vec2(
        a.z * cross + a.w * (r2 + 2.0 * ideal.x * ideal.x),
        a.z * (r2 + 2.0 * ideal.y * ideal.y) + a.w * cross,
    );
}
