//! Layers by going through every cell's points (spec 2 §2, Eq. 1-2).

use limpid::sensor::Point;

/// What a layer holds: points of a height interval (the last one's upper bound is its own), or of a ring.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Layer {
    Heights(f64, f64, bool),
    Ring(u16),
}

/// Sum of intensities in steps and number of points, by cell and then by layer; the lidar stands at (`at`, `at`) in the window.
pub(crate) fn layer_sums(
    points: &[Point],
    side: usize,
    cell_m: f64,
    at: f64,
    full: f64,
    layers: &[Layer],
) -> Vec<[u32; 2]> {
    let mut sums = vec![[0; 2]; side * side * layers.len()];
    for point in points {
        let [x, y, z] = point.position_m().map(f64::from);
        let (column, row) = (((x + at) / cell_m).floor(), ((y + at) / cell_m).floor());
        if !(0.0..side as f64).contains(&column) || !(0.0..side as f64).contains(&row) {
            continue;
        }
        let steps = ((f64::from(point.intensity) / full).clamp(0.0, 1.0) * 4080.0).round() as u32;
        for (number, layer) in layers.iter().enumerate() {
            let belongs = match *layer {
                Layer::Heights(low, high, last) => z >= low && (z < high || last && z == high),
                Layer::Ring(ring) => point.ring == ring,
            };
            if belongs {
                let sum = &mut sums[(row as usize * side + column as usize) * layers.len() + number];
                sum[0] += steps;
                sum[1] += 1;
            }
        }
    }
    sums
}
