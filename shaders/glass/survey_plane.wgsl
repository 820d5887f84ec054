// Counts by squares of the plane under test what the beams show there: glass, frame or wall, or a view through.
// spec 3 §4 (boundaries).
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(2) var<storage, read> beam_cells: array<u32>;
@group(0) @binding(3) var<storage, read> candidate_bits: array<u32>;
@group(0) @binding(4) var<storage, read> found: Found;
@group(0) @binding(5) var<storage, read_write> survey: array<atomic<u32>>;

// Beams that graze a plane say nothing about it: cosine of 80 degrees.
const GRAZING_COS = 0.17;
// Beams that an invocation counts, so that the plane is read once for them.
const EACH = 8u;

// Cosine of the angle from head on beyond which glass shows no more: what ends on its plane there, by one return, is wall or frame,
// however dim.
fn far_cos() -> f32 {
    let slope = SHOWS_TO * sqrt(max(1.0 / (glass_params.visible_cos * glass_params.visible_cos) - 1.0, 0.0));
    return inverseSqrt(1.0 + slope * slope);
}

fn count_beam(place: u32, plane: vec4<f32>, level: vec4<f32>) {
    let first = beam_cells[2u * place];
    if first == NONE {
        return;
    }
    let point = point_at(index_in(first));
    let along = dot(plane.xyz, point.xyz);
    let over = along - plane.w;
    let grazes = along < GRAZING_COS * length(point.xyz);
    for (var turn = 0u; turn < turns_if(over >= -glass_params.plane_tolerance_m && !grazes); turn++) {
        let at = point.xyz * (plane.w / along);
        let u = dot(at, level.xyz) / SQUARE_M + 0.5 * f32(SURVEY_WIDE);
        let v = dot(at, cross(plane.xyz, level.xyz)) / SQUARE_M + 0.5 * f32(SURVEY_HIGH);
        if u < 0.0 || v < 0.0 || u >= f32(SURVEY_WIDE) || v >= f32(SURVEY_HIGH) {
            return;
        }
        let shown = (candidate_bits[place / 32u] & (1u << (place % 32u))) != 0u;
        let shows = along > far_cos() * length(point.xyz);
        let dim = shows && (level.w <= 0.0 || point.w < level.w);
        let dual = two_returns(first, beam_cells[2u * place + 1u]);
        var kind = select(select(BRIGHT, DIM, dim), select(SHINING, SHOWN, dual), shown);
        kind = select(kind, BEYOND, over >= glass_params.plane_tolerance_m);
        atomicAdd(&survey[kind * SURVEY_SQUARES + u32(v) * SURVEY_WIDE + u32(u)], 1u);
    }
}

@compute @workgroup_size(64)
fn survey_plane(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = glass_params.rows * glass_params.columns;
    let stride = (size + EACH - 1u) / EACH;
    for (var turn = 0u; turn < turns_if(id.x < stride && found.inliers > 0u); turn++) {
        let plane = found.plane;
        let level = found.level;
        let turns = turns_from(id.x, size, stride);
        for (var k = 0u; k < turns; k++) {
            count_beam(id.x + k * stride, plane, level);
        }
    }
}
