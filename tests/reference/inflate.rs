//! Nav2's inflation by looking at every cell within the radius (spec 1 §3).

use limpid::Config;

/// Costs of a square grid of `side` cells.
pub(crate) fn inflate(config: &Config, side: usize, occupied: &[bool], unknown: &[bool]) -> Vec<u8> {
    let radius = (config.inflation_radius_m / config.resolution_m - 1e-6).ceil();
    let nearest = |x: usize, y: usize| {
        let reach = radius as usize;
        let rows = y.saturating_sub(reach)..=(y + reach).min(side - 1);
        let cells =
            rows.flat_map(|row| (x.saturating_sub(reach)..=(x + reach).min(side - 1)).map(move |c| (c, row)));
        cells
            .filter(|(c, row)| occupied[row * side + c])
            .map(|(c, row)| (c as f64 - x as f64).hypot(row as f64 - y as f64))
            .fold(f64::INFINITY, f64::min)
    };
    let cost = |cells: f64| {
        let metres = cells * config.resolution_m;
        if cells == 0.0 {
            254
        } else if cells > radius {
            0
        } else if metres <= config.inscribed_radius_m {
            253
        } else {
            (252.0 * (-config.cost_scaling_factor * (metres - config.inscribed_radius_m)).exp()) as u8
        }
    };
    let cells = (0..side * side).map(|i| (cost(nearest(i % side, i / side)), unknown[i]));
    cells.map(|(cost, unknown)| if unknown && cost < 253 { 255 } else { cost }).collect()
}
