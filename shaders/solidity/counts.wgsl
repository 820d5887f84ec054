// Counts what stands in each cell, and the beams of each direction with the nearest and the farthest of their ends.
// spec 6 §3: returns by height, spread along the beam, second returns, contrast within the scan; nothing by the scale of intensity.
@group(0) @binding(2) var<storage, read_write> cell_counts: array<atomic<u32>>;
@group(0) @binding(3) var<storage, read_write> beam_bins: array<atomic<u32>>;
@group(0) @binding(4) var<uniform> solidity_params: SolidityParams;
// As in intensity_layers.
@group(0) @binding(5) var<storage, read> ground_now: array<vec4<f32>>;

fn enter_beam(sector: u32, away_m: f32, z_m: f32) {
    if !(away_m > 0.0) {
        return;
    }
    let slope = u32(clamp(bin_of_slope(z_m / away_m), 0.0, f32(SLOPE_BINS) - 0.001));
    let bin = BIN_WORDS * (sector * SLOPE_BINS + slope);
    let steps = u32(min(away_m * SECTOR_STEPS_PER_M, f32(MOST_BEAM_STEPS)));
    atomicMax(&beam_bins[bin], steps);
    atomicMax(&beam_bins[bin + 1u], MOST_BEAM_STEPS + 1u - steps);
    atomicAdd(&beam_bins[bin + 2u], 1u);
    atomicAdd(&beam_bins[BIN_WORDS * SECTORS * SLOPE_BINS + slope], 1u);
}

// Deviations of an intensity from the trend of its scan; no number where it is 0 or less.
fn contrast(intensity: f32, range_m: f32) -> f32 {
    let trend = solidity_params.bright_at_1m + solidity_params.bright_slope * log2(max(range_m, 1.0e-3));
    return (log2(intensity) - trend) * solidity_params.bright_scale;
}

fn count(cell: u32, block: u32, above_m: f32, depth: f32) {
    let word = CELL_COUNTS * cell;
    atomicAdd(&cell_counts[block + band_of(above_m)], 1u);
    atomicAdd(&cell_counts[word + band_of(above_m)], 1u);
    let height = u32(clamp(above_m, 0.0, 100.0) * HEIGHT_STEPS_PER_M);
    atomicMax(&cell_counts[block + 4u], 1u + height);
    atomicMax(&cell_counts[word + 4u], ROOF_STEPS - height);
    atomicMax(&cell_counts[word + 5u], 1u + height);
    let along = u32(clamp(depth + DEPTH_ZERO, 0.0, 2.0 * DEPTH_ZERO) * DEPTH_STEPS);
    atomicAdd(&cell_counts[word + 6u], along);
    atomicAdd(&cell_counts[word + 7u], along * along);
}

fn count_light(cell: u32, intensity: f32, range_m: f32, paired: bool) {
    let word = CELL_COUNTS * cell;
    if paired {
        atomicAdd(&cell_counts[word + 8u], 1u);
    }
    if solidity_params.bright_scale > 0.0 && intensity > 0.0 {
        let deviations = clamp(contrast(intensity, range_m), -3.9, 3.9);
        atomicAdd(&cell_counts[word + 9u], 1u);
        let steps = u32((deviations + CONTRAST_ZERO) * CONTRAST_STEPS);
        atomicAdd(&cell_counts[word + 10u], steps);
        atomicAdd(&cell_counts[word + 11u], steps * steps);
    }
}

@compute @workgroup_size(64)
fn counts(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= intensity_layers_params.points {
        return;
    }
    let first = point_words(2u * id.x);
    let second = point_words(2u * id.x + 1u);
    let time_s = bitcast<f32>(second.x);
    if !all_finite(first, time_s) {
        return;
    }
    let own = vec3(bitcast<f32>(first.x), bitcast<f32>(first.y), bitcast<f32>(first.z));
    let placed = in_window(first, time_s);
    let seen = placed.xy - solidity_params.lidar;
    let up = ground_now[0];
    let z_m = dot(up.xy, seen) + up.z * placed.z;
    let lidar_m = dot(up.xy, solidity_params.lidar) + up.w;
    let above_m = z_m + lidar_m;
    // What lies below the ground is an image in it: the beam went no farther than the ground.
    let below = above_m < -solidity_params.height_min_m && lidar_m > 0.0;
    let crossing = select(1.0, lidar_m / max(lidar_m - above_m, 1.0e-6), below);
    let away_m = length(seen);
    enter_beam(sector_of(seen.x, seen.y), away_m * crossing, z_m * crossing);
    let side = solidity_params.side;
    let at = placed.xy / solidity_params.resolution_m;
    if !(at.x >= 0.0 && at.y >= 0.0 && at.x < f32(side) && at.y < f32(side)) || !(above_m >= solidity_params.height_min_m) {
        return;
    }
    let place = min(vec2<u32>(at), vec2(side - 1u));
    let cell = place.y * side + place.x;
    if above_m > solidity_params.height_max_m {
        atomicAdd(&cell_counts[CELL_COUNTS * cell + 12u], 1u);
        return;
    }
    let centre = (vec2<f32>(place) + 0.5) * solidity_params.resolution_m - solidity_params.lidar;
    count(cell, block_word(place), above_m, (away_m - length(centre)) / solidity_params.resolution_m);
    let kind = second.z & 0xffu;
    let paired = kind == FIRST_RETURN || kind == LAST_RETURN || kind == STRONGEST_RETURN;
    count_light(cell, bitcast<f32>(first.w), length(own), paired);
}
