// Beams of a scan by direction: for each sector, and each bin of slopes in it, how far the farthest reached.
// A word holds its distance in bits 14-31, in steps of 1/1024 m, and in bits 0-13 where in the bin its slope lies; so the
// largest word is that of the farthest beam. 0: no beam. Behind the bins of a sector one bit each says whether it has a beam, so
// that empty ones need not be looked at.
const SLOPE_BINS = 128u;
const BIN_MASKS = 4u;
const SECTOR_WORDS = SLOPE_BINS + BIN_MASKS;
const SLOPE_STEPS = 16384.0;
const MOST_REACH_STEPS = 262143.0;

// Slopes z / r from -infinity to infinity, on (0, SLOPE_BINS): dense near the horizontal, and without an angle function.
fn bin_of_slope(slope: f32) -> f32 {
    return (0.5 + 0.5 * slope / (1.0 + abs(slope))) * f32(SLOPE_BINS);
}

fn slope_of_bin(at: f32) -> f32 {
    let s = 2.0 * at / f32(SLOPE_BINS) - 1.0;
    return s / max(1.0 - abs(s), 1e-6);
}
