// Empties what the passes of a scan count in.
@group(0) @binding(0) var<uniform> glass_params: GlassParams;
@group(0) @binding(1) var<storage, read_write> beam_cells: array<u32>;
@group(0) @binding(2) var<storage, read_write> mirrored: array<u32>;
@group(0) @binding(3) var<storage, read_write> peaks: array<u32>;
@group(0) @binding(4) var<storage, read_write> glass_counters: array<u32>;

@compute @workgroup_size(64)
fn clear(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = glass_params.rows * glass_params.columns;
    if id.x < size {
        beam_cells[2u * id.x] = NONE;
        beam_cells[2u * id.x + 1u] = NONE;
        mirrored[id.x] = NONE;
        peaks[id.x] = 0u;
    }
    if id.x < arrayLength(&glass_counters) {
        glass_counters[id.x] = 0u;
    }
}
