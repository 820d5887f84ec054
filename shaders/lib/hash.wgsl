// A hash for draws. Needs nothing.

// PCG hash of M. Jarzynski and M. Olano, "Hash Functions for GPU Rendering", 2020.
fn hash(value: u32) -> u32 {
    let state = value * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}
