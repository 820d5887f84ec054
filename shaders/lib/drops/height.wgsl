// Heights above the ground. Needs ground_now.
fn is_ground_seen() -> bool {
    return ground_now[1].x > 0.5;
}

fn height_of(place: vec3<f32>) -> f32 {
    return dot(ground_now[0], vec4(place, 1.0));
}
