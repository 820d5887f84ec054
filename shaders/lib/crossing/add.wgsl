// Enters a beam among those of its sector. Needs lib/crossing/bins, lib/scan.
@group(0) @binding(4) var<storage, read_write> beam_reach: array<atomic<u32>>;

fn add_beam(sector: u32, range: f32, z: f32) {
    if range <= 0.0 {
        return;
    }
    let at = clamp(bin_of_slope(z / range), 0.0, f32(SLOPE_BINS) - 0.001);
    let steps = u32(min(range * SECTOR_STEPS_PER_M, MOST_REACH_STEPS));
    let within = u32(clamp(fract(at) * SLOPE_STEPS, 0.0, SLOPE_STEPS - 1.0));
    let bin = u32(at);
    atomicMax(&beam_reach[sector * SECTOR_WORDS + bin], (steps << 14u) | within);
    let mask = sector * SECTOR_WORDS + SLOPE_BINS + bin / 32u;
    let bit = 1u << (bin % 32u);
    if (atomicLoad(&beam_reach[mask]) & bit) == 0u {
        atomicOr(&beam_reach[mask], bit);
    }
}
