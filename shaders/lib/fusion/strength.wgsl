// How much the hits of a frame speak for a cell (spec 1 §9, steps 1 and 2).
struct EvidenceParams {
    camera_xy_m: vec2<f32>,     // in the window
    resolution_m: f32,
    hits_at_1_m: f32,           // n0 at a distance of 1 m; it falls with the square of the distance
    least_hits: f32,            // n0 is at least that
    exponent: f32,              // how much worse hits of a mean R under TRUSTED_R count
    looks_per_tick: f32,        // where looks count by time: the share of a look that a tick allows
    pad: u32,
}

// Mean R from which hits count fully.
const TRUSTED_R = 0.9;
// Distance from the camera under which n0 grows no more, metres.
const NEAREST_M = 0.3;

// a of the spec: of so many hits, whose R sums to `trust`.
fn strength_of_hits(params: EvidenceParams, hits: f32, trust: f32, distance_m: f32) -> f32 {
    let distance = max(distance_m, NEAREST_M);
    let enough = max(params.least_hits, params.hits_at_1_m / (distance * distance));
    let quality = clamp(trust / (hits * TRUSTED_R), 0.0, 1.0);
    return min(1.0, trust / enough) * pow(quality, params.exponent);
}
