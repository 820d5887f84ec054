// Takes the hypothesis with the most candidates near it, the first of equals, and fits a plane to these by least
// squares, three times. spec 3 §3 (refit on inliers).
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var candidates: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(2) var<storage, read> scores: array<u32>;
@group(0) @binding(3) var<storage, read_write> found: Found;

const LANES = 64u;
const REFITS = 3u;
// Bits of a float by which the quartile of intensities is searched, from the sign down.
const QUARTILE_BITS = 20u;

var<workgroup> firsts: array<vec4<f32>, LANES>;    // sums of x, y, z; count
var<workgroup> squares: array<vec4<f32>, LANES>;   // xx, yy, zz
var<workgroup> products: array<vec4<f32>, LANES>;  // xy, xz, yz
var<workgroup> best: array<vec2<u32>, LANES>;
var<workgroup> counts: array<vec4<u32>, LANES>;
var<workgroup> shared_plane: vec4<f32>;
var<workgroup> shared_quartile: vec2<u32>;  // its bits so far, twice
var<workgroup> shared_inliers: u32;

fn is_near(plane: vec4<f32>, p: vec3<f32>) -> bool {
    return abs(dot(plane.xyz, p) - plane.w) < glass_params.fit_tolerance_m;
}

// One of Jacobi's rotations of a symmetric matrix in the plane of axes p and q; columns of `vectors` turn along.
fn rotate(matrix: ptr<function, mat3x3<f32>>, vectors: ptr<function, mat3x3<f32>>, p: u32, q: u32) {
    let off = (*matrix)[p][q];
    if abs(off) < 1e-20 {
        return;
    }
    let theta = ((*matrix)[q][q] - (*matrix)[p][p]) / (2.0 * off);
    let t = select(-1.0, 1.0, theta >= 0.0) / (abs(theta) + sqrt(theta * theta + 1.0));
    let c = 1.0 / sqrt(t * t + 1.0);
    let s = t * c;
    var turn = mat3x3<f32>(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    turn[p][p] = c;
    turn[q][q] = c;
    turn[p][q] = -s;
    turn[q][p] = s;
    *matrix = transpose(turn) * *matrix * turn;
    *vectors = *vectors * turn;
}

// Direction of least variance.
fn least_axis(square: vec3<f32>, product: vec3<f32>) -> vec3<f32> {
    var matrix = mat3x3<f32>(
        vec3(square.x, product.x, product.y),
        vec3(product.x, square.y, product.z),
        vec3(product.y, product.z, square.z),
    );
    var vectors = mat3x3<f32>(vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0));
    for (var sweep = 0u; sweep < 6u; sweep++) {
        rotate(&matrix, &vectors, 0u, 1u);
        rotate(&matrix, &vectors, 0u, 2u);
        rotate(&matrix, &vectors, 1u, 2u);
    }
    let first = matrix[0][0] <= matrix[1][1] && matrix[0][0] <= matrix[2][2];
    let second = matrix[1][1] <= matrix[2][2];
    return normalize(select(select(vectors[2], vectors[1], second), vectors[0], first));
}

// Least-squares plane of the lanes' sums about `origin`; without three points `before`.
fn plane_of_sums(origin: vec3<f32>, before: vec4<f32>) -> vec4<f32> {
    var first = vec4(0.0);
    var square = vec3(0.0);
    var product = vec3(0.0);
    for (var k = 0u; k < LANES; k++) {
        first += firsts[k];
        square += squares[k].xyz;
        product += products[k].xyz;
    }
    if first.w < 3.0 {
        return before;
    }
    let mean = first.xyz / first.w;
    let n = least_axis(
        square / first.w - mean * mean,
        product / first.w - mean.xxy * mean.yzz,
    );
    let d = dot(n, mean + origin);
    return select(vec4(-n, -d), vec4(n, d), d > 0.0);
}

fn refit(lane: u32, count: u32, origin: vec3<f32>) {
    let plane = shared_plane;
    var first = vec4(0.0);
    var square = vec3(0.0);
    var product = vec3(0.0);
    for (var k = lane; k < min(count, MOST_CANDIDATES); k += LANES) {
        let p = candidate_at(k).xyz;
        if is_near(plane, p) {
            let off = p - origin;
            first += vec4(off, 1.0);
            square += off * off;
            product += off.xxy * off.yzz;
        }
    }
    firsts[lane] = first;
    squares[lane] = vec4(square, 0.0);
    products[lane] = vec4(product, 0.0);
}

// Of the candidates near the plane those whose intensity is below each of four limits.
fn count_under(lane: u32, count: u32, limits: vec4<f32>) -> vec4<u32> {
    let plane = shared_plane;
    var under = vec4(0u);
    for (var k = lane; k < min(count, MOST_CANDIDATES); k += LANES) {
        let c = candidate_at(k);
        under += select(vec4(0u), vec4(1u), (vec4(c.w) < limits) & vec4(is_near(plane, c.xyz)));
    }
    return under;
}

fn sum_of_counts() -> vec4<u32> {
    var sum = vec4(0u);
    for (var k = 0u; k < LANES; k++) {
        sum += counts[k];
    }
    return sum;
}

// Sets the next two bits of the quartile: to the largest of their four values under which there are few enough.
fn narrow(bits: u32, inliers: u32) {
    let under = sum_of_counts();
    for (var k = 1u; k < 4u; k++) {
        let trial = shared_quartile.x | (k << bits);
        if trial < 0x7f800000u && 4u * under[k] <= inliers {
            shared_quartile.y = trial;
        }
    }
    shared_quartile.x = shared_quartile.y;
}

@compute @workgroup_size(LANES)
fn fit(@builtin(local_invocation_index) lane: u32) {
    // Too few candidates make no pane; then nothing is done.
    let enough = found.candidates >= max(glass_params.min_inliers, 3u);
    let count = select(0u, found.candidates, enough);
    let hypotheses = min(glass_params.hypotheses, MOST_HYPOTHESES);
    var mine = vec2(0u, 0u);
    for (var h = lane; h < hypotheses; h += LANES) {
        if scores[h] > mine.x {
            mine = vec2(scores[h], h);
        }
    }
    best[lane] = mine;
    workgroupBarrier();
    for (var once = 0u; once < turns_if(lane == 0u); once++) {
        var top = vec2(0u, 0u);
        for (var k = 0u; k < LANES; k++) {
            if best[k].x > top.x || (best[k].x == top.x && best[k].y < top.y) {
                top = best[k];
            }
        }
        shared_plane = vec4(0.0, 0.0, 0.0, -1.0);
        if count >= 3u && top.x >= 3u {
            shared_plane = hypothesis(top.y, count);
        }
    }
    workgroupBarrier();
    // Sums about a point on the plane keep their digits.
    let origin = shared_plane.xyz * max(shared_plane.w, 0.0);
    for (var turn = 0u; turn < REFITS; turn++) {
        refit(lane, count, origin);
        workgroupBarrier();
        for (var once = 0u; once < turns_if(lane == 0u && shared_plane.w > 0.0); once++) {
            shared_plane = plane_of_sums(origin, shared_plane);
        }
        workgroupBarrier();
    }
    counts[lane] = count_under(lane, count, vec4(3.0e38));
    workgroupBarrier();
    for (var once = 0u; once < turns_if(lane == 0u); once++) {
        shared_inliers = select(0u, sum_of_counts().x, shared_plane.w > 0.0);
        shared_quartile = vec2(0u);
    }
    workgroupBarrier();
    let inliers = shared_inliers;
    // The lower quartile of their intensities: the largest value under which there are no more than a quarter.
    for (var turn = 0u; turn < QUARTILE_BITS / 2u; turn++) {
        let bits = 29u - 2u * turn;
        // Infinity and more are no intensities.
        let trials = min(vec4(shared_quartile.x) | (vec4(0u, 1u, 2u, 3u) << vec4(bits)), vec4(0x7f7fffffu));
        counts[lane] = count_under(lane, count, bitcast<vec4<f32>>(trials));
        workgroupBarrier();
        for (var once = 0u; once < turns_if(lane == 0u); once++) {
            narrow(bits, inliers);
        }
        workgroupBarrier();
    }
    for (var once = 0u; once < turns_if(lane == 0u); once++) {
        found.inliers = select(0u, inliers, inliers >= glass_params.min_inliers);
        found.plane = shared_plane;
        found.level = vec4(level_axis(shared_plane.xyz), bitcast<f32>(shared_quartile.x) * glass_params.bright_ratio);
    }
}
