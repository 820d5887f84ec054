//! Class and cost of one cell of the plan map (spec 2 §4, Eq. 11).

/// Class and Nav2 cost of a cell of class `class` with `spread` steps of inflation.
pub(crate) fn plan(class: u32, spread: u32, inscribed: bool, passable_cost: u32) -> (u32, u32) {
    let inflated = if inscribed { 253 } else { 1 + 251 * spread.min(4080) / 4080 };
    match class {
        2 | 4 => (class, 254),
        0 if !(inscribed && spread > 0) => (0, 255),
        3 if spread == 0 || inflated < passable_cost => (3, passable_cost),
        _ if spread > 0 => (5, inflated),
        1 => (1, 0),
        _ => (0, 255),
    }
}
