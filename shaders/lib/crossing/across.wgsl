// Heights at which beams crossed a cell. Needs lib/crossing/bins, lib/scan, lib/record, and Place of intensity_classes.
@group(0) @binding(8) var<storage, read> beam_reach: array<u32>;

fn record_height(height_m: f32) -> u32 {
    return u32(clamp((height_m + CROSSING_ZERO_M) * RECORD_STEPS_PER_M + 0.5, 0.0, MOST_RECORD_STEPS));
}

// Lowest and highest, 16 bits each, and the largest gap between two neighbours; 0 where no beam passed.
fn beams_across(place: Place, lidar_height_m: f32) -> vec2<u32> {
    var low = 0u;
    var high = 0u;
    var gap = 0u;
    let first = place.sector * SECTOR_WORDS;
    for (var part = 0u; part < BIN_MASKS; part++) {
        var left = beam_reach[first + SLOPE_BINS + part];
        for (var i = 0u; i < 32u; i++) {
            if left == 0u {
                break;
            }
            let bin = 32u * part + firstTrailingBit(left);
            left &= left - 1u;
            let word = beam_reach[first + bin];
            if (word >> 14u) > place.behind {
                let slope = slope_of_bin(f32(bin) + (f32(word & 0x3fffu) + 0.5) / SLOPE_STEPS);
                let height = max(record_height(lidar_height_m + place.range * slope), 1u);
                // Bins ascend, so that heights do.
                gap = select(max(gap, max(height, high) - high), 0u, high == 0u);
                low = select(low, height, high == 0u);
                high = max(high, height);
            }
        }
    }
    return vec2(low | (high << 16u), gap);
}
