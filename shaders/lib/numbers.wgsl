// Whether a value read from outside is a number: comparisons with NaN may be folded away by drivers.
fn is_finite(value: f32) -> bool {
    return (bitcast<u32>(value) & 0x7f800000u) != 0x7f800000u;
}
