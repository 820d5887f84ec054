// A tensor of quads to planes of floats, as files have it.
@group(0) @binding(3) var<storage, read_write> planes: array<f32>;

@compute @workgroup_size(64)
fn unpack(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = i32(id.x);
    if pixel >= WIDTH * HEIGHT {
        return;
    }
    let quad = i32(id.y);
    let value = load_source(vec2(pixel % WIDTH, pixel / WIDTH), quad);
    for (var c = 0; c < 4; c++) {
        planes[(4 * quad + c) * WIDTH * HEIGHT + pixel] = value[c];
    }
}
