//! Cells between two occupied ones that face each other (spec 1 §9, step 7).

/// Whether each cell lies between two of `occupied` and is none itself.
pub(crate) fn gaps(occupied: &[bool], side: usize) -> Vec<bool> {
    let at = |x: Option<usize>, y: Option<usize>| match (x, y) {
        (Some(x), Some(y)) if x < side && y < side => occupied[y * side + x],
        _ => false,
    };
    let steps = [(1_i32, 0_i32), (0, 1), (1, 1), (1, -1)];
    let cells = (0..side * side).map(|cell| (cell % side, cell / side));
    cells
        .map(|(x, y)| {
            let off = |by: i32, from: usize| from.checked_add_signed(by as isize);
            let faces = |(dx, dy)| at(off(dx, x), off(dy, y)) && at(off(-dx, x), off(-dy, y));
            !occupied[y * side + x] && steps.into_iter().any(faces)
        })
        .collect()
}
