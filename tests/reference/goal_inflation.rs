//! Inflation by asking of every cell which obstacles reach it (spec 2 §4, Eq. 8-10).

use limpid::config::{Config, InflationKernel};

/// Whether an obstacle is spread over the cell `x`, `y` cells away from it, and whether that lies within the inscribed radius.
pub(crate) fn reaches(config: &Config, theta: f64, x: f64, y: f64) -> (bool, bool) {
    let cells = |metres: f64| metres / config.scan_resolution_m + 1e-9;
    let distance = x.hypot(y);
    let inscribed = distance <= cells(config.inscribed_radius_m);
    let in_square = x.abs().max(y.abs()) <= cells(config.inflation_length_m);
    // Turned so that the goal lies along +u.
    let (u, v) = (x * theta.cos() + y * theta.sin(), y * theta.cos() - x * theta.sin());
    let half_width = f64::from(config.inflation_padding_cells) + 0.5 + 1e-9;
    let line = match config.inflation_kernel {
        InflationKernel::Uniform => in_square,
        InflationKernel::Symmetric => in_square && v.abs() <= half_width,
        InflationKernel::Adaptive => in_square && v.abs() <= half_width && u <= 1e-9,
    };
    (line || inscribed || distance <= cells(config.inflation_side_m), inscribed)
}

/// Sum of the strengths that reach each cell, and whether one does from within the inscribed radius.
pub(crate) fn inflate(config: &Config, theta: f64, side: usize, strength: &[u32]) -> Vec<[u32; 2]> {
    let obstacles: Vec<usize> = (0..strength.len()).filter(|&cell| strength[cell] > 0).collect();
    let cell = |at: usize| {
        let mut out = [0, 0];
        for &from in &obstacles {
            let (x, y) =
                ((at % side) as f64 - (from % side) as f64, (at / side) as f64 - (from / side) as f64);
            let (reached, inscribed) = reaches(config, theta, x, y);
            out[0] += if reached { strength[from] } else { 0 };
            out[1] |= u32::from(inscribed);
        }
        out
    };
    (0..side * side).map(cell).collect()
}
