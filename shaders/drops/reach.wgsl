// Marks the cells in which a scan shows the ground, and for each sector of directions how far it does. spec 6 §2 (drop-offs).
@group(0) @binding(0) var<uniform> drop_params: DropParams;
@group(0) @binding(2) var<storage, read> ground_now: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read_write> drop_marks: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> floor_reach: array<atomic<u32>>;

@compute @workgroup_size(64)
fn reach(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= drop_params.measured || !is_ground_seen() {
        return;
    }
    let at = bitcast<vec3<f32>>(point_words(2u * id.x).xyz);
    if !(is_finite(at.x) && is_finite(at.y) && is_finite(at.z)) {
        return;
    }
    let place = in_window(at);
    if abs(height_of(place)) >= drop_params.floor_m {
        return;
    }
    let cell = cell_of(place.xy);
    if cell != NO_CELL {
        atomicOr(&drop_marks[2u * cell + 1u], 1u);
    }
    let seen = place.xy - sensor_in_window().xy;
    atomicMax(&floor_reach[sector_of(seen.x, seen.y)], u32(min(length(seen), 1000.0) * SECTOR_STEPS_PER_M));
}
