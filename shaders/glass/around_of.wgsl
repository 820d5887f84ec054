// The farthest mirrored surface of each cell and its neighbours along azimuth, and how many of them have one.
// spec 3 §5 step 1. A cell of the result holds its own mirrored surface (millimetres, NONE for none), and the other two in
// one word.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var<storage, read> mirrored: array<u32>;
@group(0) @binding(2) var<storage, read_write> around: array<vec2<u32>>;

@compute @workgroup_size(64)
fn around_of(@builtin(global_invocation_id) id: vec3<u32>) {
    let columns = glass_params.columns;
    let rows = glass_params.rows;
    if id.x >= rows * columns {
        return;
    }
    let row = id.x % rows;
    let reach = glass_params.half_columns;
    var column = (id.x / rows + columns - reach) % columns;
    var seen = vec2(0u);
    for (var k = 0u; k <= 2u * reach; k++) {
        let range_mm = mirrored[column * rows + row];
        if range_mm != NONE {
            seen = vec2(max(seen.x, range_mm), seen.y + 1u);
        }
        column = select(column + 1u, 0u, column + 1u == columns);
    }
    around[id.x] = vec2(mirrored[id.x], (seen.x << COUNT_BITS) | seen.y);
}
