// Hypotheses: planes through three candidates (spec 3 §3). Needs lib/hash, lib/glass/grid, lib/glass/candidate_at.

// Three candidates closer than this make no plane, metres.
const LEAST_LEG_M = 0.2;
// Nor do three that lie nearly in line: sine of the angle between their legs.
const LEAST_SINE = 0.2;

// The second and third of a draw come from the same third of the list, which is ordered by azimuth: a pane covers a part of
// the circle.
fn draw(number: u32, count: u32) -> vec3<u32> {
    let a = hash(glass_params.seed ^ hash(3u * number));
    let b = hash(a ^ 0x9e3779b9u);
    let c = hash(b ^ 0x85ebca6bu);
    let first = a % count;
    let near = max(count / 3u, 3u);
    let start = first + count - near / 2u;
    return vec3(first, (start + b % near) % count, (start + c % near) % count);
}

// Plane number `number`: n and d > 0; d = 0 where the draw makes no plane.
fn hypothesis(number: u32, count: u32) -> vec4<f32> {
    let drawn = draw(number, count);
    let a = candidate_at(drawn.x).xyz;
    let leg_b = candidate_at(drawn.y).xyz - a;
    let leg_c = candidate_at(drawn.z).xyz - a;
    let area = cross(leg_b, leg_c);
    let lengths = vec2(length(leg_b), length(leg_c));
    if min(lengths.x, lengths.y) < LEAST_LEG_M || length(area) < LEAST_SINE * lengths.x * lengths.y {
        return vec4(0.0);
    }
    let n = normalize(area);
    let d = dot(n, a);
    return select(vec4(-n, -d), vec4(n, d), d > 0.0);
}
