//! Cost of one cell from its verdict and what was spread over it (spec 2 §4, spec 4 §2).

/// Nav2 cost of a cell of cost `base` with `spread` steps of inflation.
pub(crate) fn cost(base: u32, spread: u32, inscribed: bool) -> u32 {
    let inflated = match (spread, inscribed) {
        (0, _) => 0,
        (_, true) => 253,
        (steps, false) => 1 + 251 * steps.min(4080) / 4080,
    };
    if base == 255 && inflated < 253 {
        255
    } else if base == 255 {
        inflated
    } else {
        base.max(inflated)
    }
}
