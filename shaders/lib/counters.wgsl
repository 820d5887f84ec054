// Indices into the frame's counters.
const VALID_PIXELS = 0u;
const LOW_RELIABILITY_PIXELS = 1u;
const HIT_PIXELS = 2u;
const HIT_CELLS = 3u;
const SEEN_THROUGH_CELLS = 4u;
const OCCUPIED_CELLS = 5u;
const FREE_CELLS = 6u;
const COUNTERS = 8u;

// Counts of one strip of at most 255 pixels, in a word.
fn pack_counts(valid: u32, low: u32, hits: u32) -> u32 {
    return valid | (low << 8u) | (hits << 16u);
}
