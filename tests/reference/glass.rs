//! Cells of the organized cloud, and inliers of a plane (spec 3 §1, §3).

use std::collections::HashMap;

/// A point as a beam measured it.
pub(crate) type Beam = ([f32; 3], usize, usize);

/// Number of the nearest point of each cell (column, row, slot); of equals within a centimetre the first.
pub(crate) fn organize(beams: &[Beam], columns: usize) -> HashMap<(usize, usize, usize), usize> {
    let mut cells: HashMap<_, usize> = HashMap::new();
    let centimetres = |index: usize| {
        let [x, y, z] = beams[index].0.map(f64::from);
        ((x * x + y * y + z * z).sqrt() * 100.0) as u64
    };
    for (index, &([x, y, _], row, slot)) in beams.iter().enumerate() {
        let turn = f64::from(y).atan2(f64::from(x)) / std::f64::consts::TAU + 1.0;
        let column = (turn * columns as f64).round() as usize % columns;
        let kept = cells.entry((column, row, slot)).or_insert(index);
        if centimetres(index) < centimetres(*kept) {
            *kept = index;
        }
    }
    cells
}
