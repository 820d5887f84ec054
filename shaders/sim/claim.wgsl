// Left-right check, first half: of the left pixels that match a right pixel the one of least cost claims it.
// spec 1 §8. A claim is cost in bits 12 and up, disparity in 1/8 px below.
struct SimClaimParams {
    width: u32,
    height: u32,
}

@group(0) @binding(0) var<uniform> claim_params: SimClaimParams;
@group(0) @binding(1) var<storage, read> matched: array<u32>;
@group(0) @binding(2) var<storage, read> disparity: array<f32>;
@group(0) @binding(3) var<storage, read_write> claims: array<atomic<u32>>;

@compute @workgroup_size(64)
fn claim(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = id.x;
    let width = claim_params.width;
    if pixel >= width * claim_params.height {
        return;
    }
    // Ambiguous matches claim too: they may be the true ones.
    let found = abs(disparity[pixel]);
    let x = i32(pixel % width) - i32(round(found));
    if x >= 0 {
        let eighths = min(u32(found * 8.0), 4095u);
        atomicMin(&claims[pixel - pixel % width + u32(x)], (matched[pixel] << 12u) | eighths);
    }
}
