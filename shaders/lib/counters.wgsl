// Indices into the frame's counters.
const VALID_PIXELS = 0u;
const LOW_RELIABILITY_PIXELS = 1u;
const HIT_PIXELS = 2u;
const HIT_CELLS = 3u;
const SEEN_THROUGH_CELLS = 4u;
const OCCUPIED_CELLS = 5u;
const FREE_CELLS = 6u;
const COUNTERS = 8u;
