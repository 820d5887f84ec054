// Finds points of a scan that lie below the ground where nothing explains it: the ground is not seen where, or beyond where,
// their beams cross it. spec 6 §2 (drop-offs).
@group(0) @binding(0) var<uniform> drop_params: DropParams;
@group(0) @binding(2) var<storage, read> ground_now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> drop_marks: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read> floor_reach: array<u32>;
@group(0) @binding(5) var<storage, read> drop_cells: array<vec4<u32>>;

// Sectors on each side of a beam's own in which the ground may show: its rings do not hit every sector.
const SECTORS_BESIDE = 2u;

// Whether the ground is seen as far as a place or farther, in its direction; or there before.
fn is_ground_beyond(at: vec2<f32>) -> bool {
    let seen = at - sensor_in_window().xy;
    let steps = u32(min(length(seen), 1000.0) * SECTOR_STEPS_PER_M);
    let first = sector_of(seen.x, seen.y) + SECTORS - SECTORS_BESIDE;
    var beyond = false;
    for (var k = 0u; k < 2u * SECTORS_BESIDE + 1u; k++) {
        beyond = beyond || floor_reach[(first + k) % SECTORS] >= steps;
    }
    let cell = cell_of(at);
    if cell != NO_CELL {
        beyond = beyond || is_known_ground(cell);
    }
    return beyond;
}

@compute @workgroup_size(64)
fn returns(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= drop_params.measured || !is_ground_seen() {
        return;
    }
    let at = bitcast<vec3<f32>>(point_words(2u * id.x).xyz);
    if !(is_finite(at.x) && is_finite(at.y) && is_finite(at.z)) {
        return;
    }
    let place = in_window(at);
    let height = height_of(place);
    for (var turn = 0u; turn < turns_if(is_deep(place, height)); turn++) {
        let crossing = crossing_of(place, height);
        mark(crossing, place.xy, is_ground_beyond(crossing));
    }
}
