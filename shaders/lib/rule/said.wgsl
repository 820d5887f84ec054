// What a layer says of a cell, for the rule (spec 4 §2).
struct Said {
    state: u32,     // bits of the rule
    tick: u32,      // of its last evidence
    sensor: u32,    // + 1; 0: none
}

// Heights above the ground, metres: where a camera was hit, or between which beams crossed.
struct Span {
    low_m: f32,
    high_m: f32,
    gap_m: f32,     // largest gap between neighbouring beams
}
