//! The paper's results (spec 1 §7), to stand beside ours.

/// A row of the paper's Tables IV and V.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Glare level.
    pub level: &'static str,
    /// Method, by its name in our reports.
    pub method: &'static str,
    /// Hole rate, spike rate and RMSE in metres, where the paper gives them.
    pub sensor: Option<[f64; 3]>,
    /// FOR and FSR.
    pub map: [f64; 2],
}

const fn row(level: &'static str, method: &'static str, sensor: Option<[f64; 3]>, map: [f64; 2]) -> Row {
    Row { level, method, sensor, map }
}

/// All rows.
pub const ROWS: [Row; 15] = [
    row("L0", "naive", Some([0.012, 0.005, 0.022]), [0.009, 0.993]),
    row("L0", "range", None, [0.008, 0.993]),
    row("L0", "median", None, [0.008, 0.990]),
    row("L0", "temporal", None, [0.007, 0.991]),
    row("L0", "drm", Some([0.011, 0.004, 0.021]), [0.008, 0.995]),
    row("L1", "naive", Some([0.185, 0.094, 0.185]), [0.168, 0.792]),
    row("L1", "range", None, [0.125, 0.840]),
    row("L1", "median", None, [0.095, 0.890]),
    row("L1", "temporal", None, [0.080, 0.910]),
    row("L1", "drm", Some([0.028, 0.012, 0.045]), [0.024, 0.968]),
    row("L2", "naive", Some([0.452, 0.276, 0.840]), [0.432, 0.515]),
    row("L2", "range", None, [0.350, 0.620]),
    row("L2", "median", None, [0.310, 0.650]),
    row("L2", "temporal", None, [0.245, 0.710]),
    row("L2", "drm", Some([0.054, 0.031, 0.082]), [0.056, 0.897]),
];

/// The paper's row for a level and method.
pub fn find(level: &str, method: &str) -> Option<&'static Row> {
    ROWS.iter().find(|row| row.level == level && row.method == method)
}
