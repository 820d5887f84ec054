// The depthwise half of a block of many channels: upsampling and 3x3 convolution of one quad for each row of the grid.
// spec 1 §1.
@compute @workgroup_size(64)
fn depthwise(@builtin(global_invocation_id) id: vec3<u32>) {
    find_lane();
    let first = first_of_tile(id.x);
    let quad = i32(id.y);
    var source_at = source_window(first, window_at(first));
    var taps = source_taps(&source_at, quad);
    let outputs = depthwise_tile(&taps, FIRST_QUAD + quad);
    for (var p = 0; p < PIXELS; p++) {
        let at = pixel_of_tile(first, p);
        if is_inside(at) {
            store_sink(at, FIRST_QUAD + quad, outputs[p]);
        }
    }
}
