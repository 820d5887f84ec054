//! Class, value and glass of one cell (spec 2 §3, Eq. 3-7).

/// One cell's layers: value and returns of the tall ones, then of the planes z = 0 and z = -epsilon.
pub(crate) struct Cell {
    pub(crate) tall: Vec<(f64, u32)>,
    pub(crate) plane: (f64, u32),
    pub(crate) below: (f64, u32),
    pub(crate) crossed: bool,
    /// Steps of glass remembered.
    pub(crate) remembered: u32,
}

/// Thresholds.
pub(crate) struct Limits {
    pub(crate) gamma: f64,
    pub(crate) transparent: f64,
    pub(crate) min_returns: u32,
}

/// Class, strength and remembered glass in steps; full value 1.
pub(crate) fn classify(cell: &Cell, limits: &Limits) -> [u32; 3] {
    let steps = |value: f64| ((value.clamp(0.0, 1.0) * 4080.0 + 0.5).floor() as u32).max(1);
    let tallest = cell.tall.iter().map(|layer| layer.0).fold(0.0, f64::max);
    let returns = cell.tall.iter().map(|layer| layer.1).sum::<u32>().max(cell.plane.1);
    let value = tallest.max(cell.plane.0);
    let decided = returns >= limits.min_returns;
    let excess = (cell.plane.0 - cell.below.0).max(0.0);
    let glass = decided && excess > limits.transparent && tallest <= limits.gamma;
    let remembered = cell.remembered.max(if glass { steps(excess) } else { 0 });
    let solid = decided && value > limits.gamma;
    let class = match (solid, remembered > 0, decided, returns == 0 && cell.crossed) {
        (true, ..) => 2,
        (_, true, ..) => 4,
        (_, _, true, _) => 3,
        (.., true) => 1,
        _ => 0,
    };
    [class, remembered.max(if solid { steps(value) } else { 0 }), remembered]
}
