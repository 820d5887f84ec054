// Keeps how near a scan sees something in each direction. spec 6 §2 (drop-offs: what a glossy floor mirrors).
@group(0) @binding(0) var<uniform> drop_params: DropParams;
@group(0) @binding(4) var<storage, read_write> drop_view: array<atomic<u32>>;

@compute @workgroup_size(64)
fn view(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = point_of(id.x);
    if at.w == 0.0 {
        return;
    }
    let off = in_window(at.xyz) - sensor_in_window();
    let seen = view_of(off);
    atomicMax(&drop_view[seen.x * VIEW_BINS + seen.y], view_steps(off));
}
