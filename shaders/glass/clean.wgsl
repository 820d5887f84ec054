// The cloud as the map takes it: what a pane mirrors, and what is not decided behind one, ends on the pane. spec 3 §7.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(2) var<storage, read> panes: Panes;
@group(0) @binding(3) var<storage, read> classes: array<u32>;
@group(0) @binding(4) var<storage, read_write> clean_points: array<vec4<u32>>;

@compute @workgroup_size(64)
fn clean(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= glass_params.points {
        return;
    }
    let point = point_at(id.x);
    var place = point.xyz;
    let kind = classes[id.x] & 0xffu;
    let pane_id = classes[id.x] >> 8u;
    let virtual_point = kind == REFLECTION || kind == UNLABELLED;
    for (var k = 0u; k < min(panes.slots, KEPT_PANES); k++) {
        if virtual_point && pane_id != 0u && panes.list[k].id == pane_id {
            place = point.xyz * cross_pane(panes.list[k], point.xyz, MARGIN_M).share;
        }
    }
    clean_points[2u * id.x] = bitcast<vec4<u32>>(vec4(place, point.w));
    clean_points[2u * id.x + 1u] = rest_of_point(id.x);
}
