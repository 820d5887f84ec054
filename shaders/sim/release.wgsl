// Frees all pixels of the right image for the left-right check.
struct SimReleaseParams {
    pixels: u32,
    pad0: u32,
}

@group(0) @binding(0) var<uniform> release_params: SimReleaseParams;
@group(0) @binding(1) var<storage, read_write> claims: array<u32>;

@compute @workgroup_size(64)
fn release(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < release_params.pixels {
        claims[id.x] = 0xffffffffu;
    }
}
