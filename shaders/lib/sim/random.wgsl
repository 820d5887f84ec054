// Repeatable noise: integer hashes, and smooth noise on a lattice (value noise).
fn hash(value: u32) -> u32 {
    var v = value * 747796405u + 2891336453u;
    v = ((v >> ((v >> 28u) + 4u)) ^ v) * 277803737u;
    return (v >> 22u) ^ v;
}

fn hash3(x: i32, y: i32, seed: u32) -> u32 {
    return hash(bitcast<u32>(x) ^ hash(bitcast<u32>(y) ^ hash(seed)));
}

// In [0, 1).
fn unit(bits: u32) -> f32 {
    return f32(bits >> 8u) * (1.0 / 16777216.0);
}

// Near normal with mean 0 and deviation 1: the sum of the four bytes.
fn normal(bits: u32) -> f32 {
    let sum = (bits & 255u) + ((bits >> 8u) & 255u) + ((bits >> 16u) & 255u) + (bits >> 24u);
    return (f32(sum) - 510.0) * (1.0 / 147.8);
}

// Smooth noise in [0, 1], one lattice value a unit.
fn value_noise(at: vec2<f32>, seed: u32) -> f32 {
    let cell = floor(at);
    let share = at - cell;
    let blend = share * share * (3.0 - 2.0 * share);
    let x = i32(cell.x);
    let y = i32(cell.y);
    let low = mix(unit(hash3(x, y, seed)), unit(hash3(x + 1, y, seed)), blend.x);
    let high = mix(unit(hash3(x, y + 1, seed)), unit(hash3(x + 1, y + 1, seed)), blend.x);
    return mix(low, high, blend.y);
}
