// Puts every point into its cell of the organized cloud; of several the nearest stays, of equals the first.
// spec 3 §1.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(3) var row_texels: texture_storage_2d_array<rgba32float, read>;
@group(0) @binding(4) var<storage, read_write> beam_cells: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> glass_counters: array<atomic<u32>>;
@group(0) @binding(6) var placed: texture_storage_2d_array<rgba32float, write>;

// Nearer than this nothing is measured, metres.
const LEAST_RANGE_M = 0.05;
// Farther than this no coordinate is taken for measured.
const MOST_RANGE_M = 1000.0;

// The ring of a point that has none (sensor::Point::UNKNOWN).
const NO_RING = 0xffffu;

// By ring; by elevation where no point has a ring, or this one has none.
fn row_of(p: vec3<f32>, ring: u32) -> u32 {
    var row = NONE;
    for (var turn = 0u; turn < turns_if(glass_params.rings == 0u || ring == NO_RING); turn++) {
        row = row_of_bin(elevation_bin(p));
    }
    for (var turn = 0u; turn < turns_if(ring < glass_params.rings); turn++) {
        row = row_of_ring(ring);
    }
    return row;
}

fn place_point(index: u32) {
    let point = point_at(index);
    let rest = rest_of_point(index);
    let finite = is_finite(point.x) && is_finite(point.y) && is_finite(point.z) && is_finite(point.w);
    let largest = max(max(abs(point.x), abs(point.y)), abs(point.z));
    var row = NONE;
    if !finite || largest > MOST_RANGE_M || largest < LEAST_RANGE_M {
        atomicAdd(&glass_counters[COUNT_UNUSABLE], 1u);
    } else {
        row = row_of(point.xyz, ring_of(rest));
        if row >= glass_params.rows {
            atomicAdd(&glass_counters[COUNT_NO_ROW], 1u);
        }
    }
    // Without a place: a point that is no number meets nothing.
    var texel = vec4(0.0);
    for (var once = 0u; once < turns_if(row < glass_params.rows); once++) {
        let place = column_of(point.xyz, glass_params.columns) * glass_params.rows + row;
        let cell = 2u * place + slot_of_return(rest);
        atomicMin(&beam_cells[cell], cell_word(length(point.xyz), index));
        texel = vec4(point.xyz, f32(1u + cell));
    }
    textureStore(placed, placed_texel(index), 0u, texel);
}

@compute @workgroup_size(64)
fn organize(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let turns = turns_from(id.x, glass_params.points, 64u * groups.x);
    for (var turn = 0u; turn < turns; turn++) {
        place_point(id.x + 64u * groups.x * turn);
    }
}
