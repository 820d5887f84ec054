// Farthest trusted depth of each strip of TILE pixels down a column.
// spec 1 §3 (seen through): first half of the far tiles.
struct SeeThroughStripsParams {
    width: u32,
    height: u32,
    tau: f32,
    pad: u32,
}

@group(0) @binding(0) var<uniform> see_through_strips_params: SeeThroughStripsParams;
@group(0) @binding(1) var<storage, read> depth_m: array<f32>;
@group(0) @binding(2) var<storage, read> reliability: array<f32>;
@group(0) @binding(3) var<storage, read_write> far_strips: array<f32>;

@compute @workgroup_size(64)
fn strips(@builtin(global_invocation_id) id: vec3<u32>) {
    let width = see_through_strips_params.width;
    if id.x >= width {
        return;
    }
    var far = 0.0;
    let end = min((id.y + 1u) * TILE, see_through_strips_params.height);
    for (var v = id.y * TILE; v < end; v++) {
        let pixel = v * width + id.x;
        far = max(far, select(0.0, depth_m[pixel], reliability[pixel] > see_through_strips_params.tau));
    }
    far_strips[id.y * width + id.x] = far;
}
