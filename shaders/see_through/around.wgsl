// Farthest trusted depth in each tile and the eight around it.
// spec 1 §3 (seen through).
struct SeeThroughAroundParams {
    tiles_x: u32,
    tiles_y: u32,
}

@group(0) @binding(0) var<uniform> see_through_around_params: SeeThroughAroundParams;
@group(0) @binding(1) var<storage, read> tile_far_m: array<f32>;
@group(0) @binding(2) var<storage, read_write> around_far_m: array<f32>;

@compute @workgroup_size(16, 4)
fn around(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = vec2(see_through_around_params.tiles_x, see_through_around_params.tiles_y);
    if id.x >= size.x || id.y >= size.y {
        return;
    }
    var far = 0.0;
    for (var i = 0u; i < 9u; i++) {
        let near = clamp(id.xy + vec2(i % 3u, i / 3u), vec2(1u), size) - 1u;
        far = max(far, tile_far_m[near.y * size.x + near.x]);
    }
    around_far_m[id.y * size.x + id.x] = far;
}
