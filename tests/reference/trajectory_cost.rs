//! Places along an arc by turning about its centre, and the cost of the cells under them (spec 2 §5, Eq. 12).

/// Place after `time_s` at (v, omega) from `start` and `heading`.
pub(crate) fn place(start: [f64; 2], heading: f64, [v, omega]: [f64; 2], time_s: f64) -> [f64; 2] {
    if omega == 0.0 {
        return [start[0] + v * time_s * heading.cos(), start[1] + v * time_s * heading.sin()];
    }
    let (radius, after) = (v / omega, heading + omega * time_s);
    [start[0] + radius * (after.sin() - heading.sin()), start[1] - radius * (after.cos() - heading.cos())]
}

/// Sum of costs, worst known cost, cells, unknown cells; a cell counts again where the way comes back to it.
pub(crate) fn cost(
    costs: &[u8],
    side: usize,
    cell_m: f64,
    places: &[[f32; 2]],
    unknown_cost: u32,
) -> [u32; 4] {
    let cell = |place: &[f32; 2]| {
        let at = place.map(|m| (f64::from(m) / cell_m).floor());
        let inside = at.iter().all(|&c| c >= 0.0 && c < side as f64);
        inside.then(|| at[1] as usize * side + at[0] as usize)
    };
    let mut cells: Vec<Option<usize>> = places.iter().map(cell).collect();
    cells.dedup();
    let mut total = [0; 4];
    for cell in cells {
        let known = cell.map(|cell| u32::from(costs[cell])).filter(|&cost| cost != 255);
        total[0] += known.unwrap_or(unknown_cost);
        total[1] = total[1].max(known.unwrap_or(0));
        total[2] += 1;
        total[3] += u32::from(known.is_none());
    }
    total
}
