// The field around a sensor in which planes are measured: squares, a bit each, and sectors of directions. Needs lib/ground/ground.

// Squares along a side of the field around the sensor in which planes are measured, a bit each.
const FIELD = 64u;
const FIELD_WORDS = 128u;
const SPREAD_SECTORS = 32u;

// The bit of the square around a place: word and bit; a word of FIELD_WORDS lies outside.
fn square_of(at: vec2<f32>) -> vec2<u32> {
    let square = floor(at / ground_params.square_m) + 0.5 * f32(FIELD);
    if !(square.x >= 0.0 && square.y >= 0.0 && square.x < f32(FIELD) && square.y < f32(FIELD)) {
        return vec2(FIELD_WORDS, 0u);
    }
    let number = u32(square.y) * FIELD + u32(square.x);
    return vec2(number / 32u, number % 32u);
}

// Sector of a direction: quarters by sign, evenly in |y| / (|x| + |y|) within.
fn sector_of(at: vec2<f32>) -> u32 {
    let share = abs(at.y) / max(abs(at.x) + abs(at.y), 1.0e-6);
    var turn = select(share, 2.0 - share, at.x < 0.0);
    turn = select(turn, 4.0 - turn, at.y < 0.0);
    return min(u32(turn * f32(SPREAD_SECTORS) / 4.0), SPREAD_SECTORS - 1u);
}
