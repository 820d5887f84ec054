// Farthest trusted depth in and around each tile, a tile's side to every direction.
// spec 1 §3 (seen through): second half of the far tiles.
struct SeeThroughTilesParams {
    width: u32,
    tiles_x: u32,
    tiles_y: u32,
    pad: u32,
}

@group(0) @binding(0) var<uniform> see_through_tiles_params: SeeThroughTilesParams;
@group(0) @binding(1) var<storage, read> far_strips: array<f32>;
@group(0) @binding(2) var<storage, read_write> far_tiles: array<f32>;

@compute @workgroup_size(16, 4)
fn tiles(@builtin(global_invocation_id) id: vec3<u32>) {
    let width = see_through_tiles_params.width;
    if id.x >= see_through_tiles_params.tiles_x || id.y >= see_through_tiles_params.tiles_y {
        return;
    }
    var far = 0.0;
    let first_x = max(id.x * TILE, TILE) - TILE;
    let end_x = min((id.x + 2u) * TILE, width);
    let first_y = max(id.y, 1u) - 1u;
    let end_y = min(id.y + 2u, see_through_tiles_params.tiles_y);
    for (var y = first_y; y < end_y; y++) {
        for (var x = first_x; x < end_x; x++) {
            far = max(far, far_strips[y * width + x]);
        }
    }
    far_tiles[id.y * see_through_tiles_params.tiles_x + id.x] = far;
}
