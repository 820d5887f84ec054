// Draws planes that may be the ground: the one that is known, the stated one, and planes through three samples that lie level
// enough to each other. spec 6 §2 (RANSAC, seeded by the last plane, gravity from tf as a prior).
@group(0) @binding(0) var<uniform> ground_params: GroundParams;
@group(0) @binding(1) var ground_samples: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(2) var<storage, read> ground: array<Kept>;
@group(0) @binding(3) var<storage, read_write> ground_planes: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> ground_scores: array<u32>;

// Draws for each of the three: most samples are walls, and what stands on the ground.
const TRIES = 24u;
// Two samples of a draw lie so far apart along the ground, metres.
const LEAST_LEG_M = 0.2;
const MOST_LEG_M = 4.0;
// Three nearly in line make no plane: sine of the angle between the legs.
const LEAST_SINE = 0.3;

fn drawn(number: u32) -> vec4<f32> {
    let samples = max(ground_params.columns * ground_params.rows, 1u);
    return textureLoad(ground_samples, sample_texel(min(hash(number) % samples, MOST_SAMPLES - 1u)), 0u);
}

// Whether b lies level enough beside a.
fn is_level(a: vec4<f32>, b: vec4<f32>) -> bool {
    let leg = b.xyz - a.xyz;
    let along = length(leg.xy);
    return b.w > 0.0 && along >= LEAST_LEG_M && along <= MOST_LEG_M && abs(leg.z) <= ground_params.most_slope * along;
}

fn plane_of_draw(number: u32) -> vec4<f32> {
    let seed = hash(number ^ hash(ground_params.tick));
    var a = vec4(0.0);
    for (var k = 0u; k < TRIES; k++) {
        let other = drawn(seed + k);
        if a.w == 0.0 {
            a = other;
        }
    }
    var b = vec4(0.0);
    for (var k = 0u; k < TRIES; k++) {
        let other = drawn(seed + TRIES + k);
        if b.w == 0.0 && a.w > 0.0 && is_level(a, other) {
            b = other;
        }
    }
    var c = vec4(0.0);
    for (var k = 0u; k < TRIES; k++) {
        let other = drawn(seed + 2u * TRIES + k);
        let legs = vec4(b.xy - a.xy, other.xy - a.xy);
        let area = abs(legs.x * legs.w - legs.y * legs.z);
        if c.w == 0.0 && b.w > 0.0 && is_level(a, other) && area >= LEAST_SINE * length(legs.xy) * length(legs.zw) {
            c = other;
        }
    }
    if c.w == 0.0 {
        return NO_PLANE;
    }
    let across = normalize(cross(b.xyz - a.xyz, c.xyz - a.xyz));
    let n = select(across, -across, across.z < 0.0);
    return vec4(n, dot(n, a.xyz));
}

@compute @workgroup_size(64)
fn draw(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= HYPOTHESES {
        return;
    }
    var plane = NO_PLANE;
    let known = best_kept();
    if id.x == 0u && known < ground_params.sensors {
        plane = from_sensor(ground[known]);
    } else if id.x == 1u && ground_params.has_map == 1u {
        plane = vec4(0.0, 0.0, 1.0, ground_params.stated_z - sensor_place().z);
    } else if id.x > 1u {
        plane = plane_of_draw(id.x);
    }
    // Too steep for a ground, or not below the sensor.
    if length(plane.xy) > ground_params.most_slope * plane.z || plane.w > -LEAST_BELOW_M {
        plane = NO_PLANE;
    }
    ground_planes[id.x] = plane;
    ground_scores[id.x] = 0u;
}
