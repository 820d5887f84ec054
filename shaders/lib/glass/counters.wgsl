// Indices into a scan's counters (map::glass::GlassCounters).
const COUNT_UNUSABLE = 0u;
const COUNT_NO_ROW = 1u;
const COUNT_DUAL = 2u;
const COUNT_PEAK = 3u;
const COUNT_CANDIDATES = 4u;
const COUNT_THINNED = 5u;
const COUNT_REFUSED = 6u;
const COUNT_FOUND = 7u;
const COUNT_CLASSES = 8u;       // one for each class, five
const COUNT_MIRRORS = 13u;
