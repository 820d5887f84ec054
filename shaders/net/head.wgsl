// The head alone: 1x1 convolution to one channel, sigmoid. spec 1 §1.
@group(0) @binding(3) var<storage, read_write> reliability_low: array<f32>;

@compute @workgroup_size(64)
fn head(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = i32(id.x);
    if pixel >= WIDTH * HEIGHT {
        return;
    }
    let at = vec2(pixel % WIDTH, pixel / WIDTH);
    var logit = load_weights(0, SOURCE_QUADS).x;
    for (var quad = 0; quad < SOURCE_QUADS; quad++) {
        logit += dot(load_weights(0, quad), load_source(at, quad));
    }
    reliability_low[pixel] = reliability_of(logit);
}
