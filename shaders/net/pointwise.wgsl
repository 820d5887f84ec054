// The pointwise half of a block of many channels: 1x1 convolution to OUT_QUADS quads of outputs for each row of the grid.
// spec 1 §1.
@compute @workgroup_size(64)
fn pointwise(@builtin(global_invocation_id) id: vec3<u32>) {
    find_lane();
    let first = first_of_tile(id.x);
    let first_quad = i32(id.y) * OUT_QUADS;
    var sums: Sums;
    start_sums(&sums, SOURCE_QUADS, first_quad);
    for (var quad = 0; quad < SOURCE_QUADS; quad++) {
        var inputs: Tile;
        for (var p = 0; p < PIXELS; p++) {
            inputs[p] = load_source(min(pixel_of_tile(first, p), vec2(WIDTH, HEIGHT) - 1), quad);
        }
        add_quad(&sums, &inputs, quad, 16 + 4 * first_quad, 4);
    }
    finish(&sums, first, first_quad);
}
