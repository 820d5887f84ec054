// Farthest trusted depth in each tile, from the strips that back_project left.
// spec 1 §3 (seen through).
struct SeeThroughTilesParams {
    width: u32,
    tiles_x: u32,
    tiles_y: u32,
    pad: u32,
}

@group(0) @binding(0) var<uniform> see_through_tiles_params: SeeThroughTilesParams;
@group(0) @binding(1) var<storage, read> strip_far_m: array<f32>;
@group(0) @binding(2) var<storage, read_write> tile_far_m: array<f32>;

@compute @workgroup_size(16, 4)
fn tiles(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= see_through_tiles_params.tiles_x || id.y >= see_through_tiles_params.tiles_y {
        return;
    }
    var far = 0.0;
    for (var i = 0u; i < TILE; i++) {
        let x = min(id.x * TILE + i, see_through_tiles_params.width - 1u);
        far = max(far, strip_far_m[id.y * see_through_tiles_params.width + x]);
    }
    tile_far_m[id.y * see_through_tiles_params.tiles_x + id.x] = far;
}
