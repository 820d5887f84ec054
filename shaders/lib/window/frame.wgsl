// Clears a frame's sums. Needs lib/counters.
@group(0) @binding(2) var<storage, read_write> cell_hits: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read_write> seen_through: array<u32>;
@group(0) @binding(4) var<storage, read_write> counters: array<u32>;

fn clear_counter(number: u32) {
    if number < COUNTERS {
        counters[number] = 0u;
    }
}

fn clear_sums(cell: u32) {
    cell_hits[cell] = vec4(0u);
    seen_through[cell] = 0u;
}
