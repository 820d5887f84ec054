// Mirrors what lies before a pane through it, into the cells of the beams that would see it there. spec 3 §5 step 1, §6.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var<storage, read> points: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read> cells: array<u32>;
@group(0) @binding(3) var<storage, read> elevation_rows: array<u32>;
@group(0) @binding(4) var<storage, read> panes: Panes;
@group(0) @binding(5) var<storage, read_write> mirrored: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> pane_counts: array<atomic<u32>>;

// Nearer to the plane than this a point is part of the pane's frame, metres.
const FRONT_M = 0.1;
const MM_PER_M = 1000.0;

@compute @workgroup_size(64)
fn mirror(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= glass_params.rows * glass_params.columns {
        return;
    }
    let first = cells[2u * id.x];
    if first == NONE {
        return;
    }
    let p = points[2u * index_in(first)].xyz;
    if first_met(p).slot != NONE {
        return;
    }
    for (var k = 0u; k < min(panes.slots, KEPT_PANES); k++) {
        let pane = panes.list[k];
        let before = pane.normal.w - dot(pane.normal.xyz, p);
        if pane.id != 0u && before > FRONT_M {
            let depth_mm = u32(before * MM_PER_M);
            if depth_mm > atomicLoad(&pane_counts[k * PANE_COUNTS + ROOM_DEPTH]) {
                atomicMax(&pane_counts[k * PANE_COUNTS + ROOM_DEPTH], depth_mm);
            }
            let image = mirrored_in(pane, p);
            let row = elevation_rows[elevation_bin(image)];
            if row < glass_params.rows && first_met(image).slot == k {
                let place = column_of(image, glass_params.columns) * glass_params.rows + row;
                atomicMin(&mirrored[place], u32(length(image) * MM_PER_M));
            }
        }
    }
}
