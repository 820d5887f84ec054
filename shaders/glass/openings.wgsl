// Counts by strips of each wall the beams that go on behind it, and lists them for glass/images. Four walls at once. spec 6 §4.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(2) var<storage, read> beam_cells: array<u32>;
@group(0) @binding(3) var<storage, read> scan_walls: Walls;
@group(0) @binding(4) var<storage, read_write> wall_strips: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> passed_beams: array<atomic<u32>>;

// Beams that an invocation looks at, so that the walls are read once for them.
const EACH = 8u;
// Walls that a beam goes through at most: of rooms that are no rectangle the walls' planes cross the room.
const MOST_PASSED = 2u;

// The walls' planes or level axes by their coordinates.
struct Axes {
    x: vec4<f32>,
    y: vec4<f32>,
    z: vec4<f32>,
    w: vec4<f32>,
}

fn by_coordinates(of_walls: array<vec4<f32>, WALLS>) -> Axes {
    let rows = transpose(mat4x4<f32>(of_walls[0], of_walls[1], of_walls[2], of_walls[3]));
    return Axes(rows[0], rows[1], rows[2], rows[3]);
}

fn along(axes: Axes, p: vec3<f32>) -> vec4<f32> {
    return axes.x * p.x + axes.y * p.y + axes.z * p.z;
}

// How many of four values are less than number `k`; of equal ones the first is the least.
fn rank(values: vec4<f32>, k: u32) -> u32 {
    let before = vec4(0u, 1u, 2u, 3u) < vec4(k);
    let less = (values < vec4(values[k])) | ((values == vec4(values[k])) & before);
    let one = select(vec4(0u), vec4(1u), less);
    return one.x + one.y + one.z + one.w;
}

fn count_passing(place: u32, wall: u32, strip: u32, dual: bool) {
    let at = strip_at(wall, strip);
    atomicAdd(&wall_strips[at + GO_ON], 1u);
    if dual {
        atomicAdd(&wall_strips[at + TWICE], 1u);
    }
    let number = atomicAdd(&passed_beams[PASSED_COUNT], 1u);
    atomicStore(&passed_beams[1u + number], place | (wall << PLACE_BITS));
}

fn count_beam(place: u32, planes: Axes, levels: Axes, glazed: Axes) {
    let first = beam_cells[2u * place];
    if first == NONE {
        return;
    }
    let p = point_at(index_in(first)).xyz;
    let reach = along(planes, p);
    let over = reach - planes.w;
    let share = planes.w / max(reach, vec4(1e-6));
    let u = along(levels, p) * share;
    let strip = u / STRIP_M + 0.5 * f32(STRIPS);
    let meets = (planes.w > vec4(0.0)) & (over >= vec4(-glass_params.plane_tolerance_m)) & (reach > vec4(GRAZING_COS * length(p)))
        & (strip >= vec4(0.0)) & (strip < vec4(f32(STRIPS))) & ((u < glazed.x) | (u > glazed.y));
    let goes_on = meets & (over > vec4(BEHIND_M));
    for (var once = 0u; once < turns_if(any(meets)); once++) {
        let dual = two_returns(first, beam_cells[2u * place + 1u]);
        let shares = select(vec4(2.0), share, goes_on);
        for (var k = 0u; k < WALLS; k++) {
            if goes_on[k] && rank(shares, k) < MOST_PASSED {
                count_passing(place, k, u32(strip[k]), dual);
            } else if dual && meets[k] && over[k] < glass_params.plane_tolerance_m {
                atomicAdd(&wall_strips[strip_at(k, u32(strip[k])) + GLAZED], 1u);
            }
        }
    }
}

@compute @workgroup_size(64)
fn openings(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = glass_params.rows * glass_params.columns;
    let stride = (size + EACH - 1u) / EACH;
    let planes = by_coordinates(scan_walls.planes);
    let levels = by_coordinates(scan_walls.levels);
    let glazed = by_coordinates(scan_walls.glazed);
    let turns = select(0u, turns_from(id.x, size, stride), id.x < stride && any(planes.w > vec4(0.0)));
    for (var k = 0u; k < turns; k++) {
        count_beam(id.x + k * stride, planes, levels, glazed);
    }
}
