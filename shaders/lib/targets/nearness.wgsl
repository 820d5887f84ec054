// 1 / depth in fixed point, 2^27 a unit, so that of two points the nearer has the greater; 0 is none.
const NEARNESS_ONE = 134217728.0;
const NEAREST_M = 0.05;
const FARTHEST_M = 1000.0;

fn nearness(depth: f32) -> u32 {
    return u32(NEARNESS_ONE / depth + 0.5);
}

fn depth_of(nearness: u32) -> f32 {
    return select(0.0, NEARNESS_ONE / f32(max(nearness, 1u)), nearness > 0u);
}
