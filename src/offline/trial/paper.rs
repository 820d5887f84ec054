//! The papers' drives (spec 1 §7, spec 2 §6), to stand beside ours.

/// A row of the glare paper's Table VI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Glare level.
    pub level: &'static str,
    /// Method, by its name in our tables.
    pub method: &'static str,
    /// Emergency stops per 10 m.
    pub stops: f64,
    /// Percent.
    pub success: f64,
    /// Path length ratio, detours in percent, seconds to the goal, where the paper gives them.
    pub way: Option<[f64; 3]>,
}

const fn drive(
    level: &'static str,
    method: &'static str,
    stops: f64,
    success: f64,
    way: Option<[f64; 3]>,
) -> Drive {
    Drive { level, method, stops, success, way }
}

/// All rows.
pub const DRIVES: [Drive; 15] = [
    drive("L0", "naive", 0.12, 100.0, Some([1.01, 0.0, 45.2])),
    drive("L0", "range", 0.12, 100.0, None),
    drive("L0", "median", 0.11, 100.0, None),
    drive("L0", "temporal", 0.10, 100.0, None),
    drive("L0", "drm", 0.10, 100.0, Some([1.01, 0.0, 45.1])),
    drive("L1", "naive", 2.35, 81.5, Some([1.24, 25.0, 58.4])),
    drive("L1", "range", 1.80, 88.0, None),
    drive("L1", "median", 1.20, 92.5, None),
    drive("L1", "temporal", 0.95, 95.0, None),
    drive("L1", "drm", 0.32, 98.2, Some([1.04, 5.0, 47.3])),
    drive("L2", "naive", 6.84, 28.6, Some([2.84, 85.0, 124.7])),
    drive("L2", "range", 5.10, 45.5, None),
    drive("L2", "median", 4.50, 52.0, None),
    drive("L2", "temporal", 3.20, 68.5, None),
    drive("L2", "drm", 0.85, 91.4, Some([1.08, 12.0, 49.8])),
];

/// The paper's row for a level and method.
pub fn drive_of(level: &str, method: &str) -> Option<&'static Drive> {
    DRIVES.iter().find(|row| row.level == level && row.method == method)
}

/// A row of the intensity paper's Table I: scenario, method, success in percent, normalised length, F-score.
pub type LidarRow = (&'static str, &'static str, f64, Option<f64>, Option<f64>);

/// Its rows with a method of ours.
pub const LIDAR: [LidarRow; 10] = [
    ("glass", "laser_scan", 0.0, None, Some(0.12)),
    ("glass", "occupancy", 0.0, None, Some(0.20)),
    ("glass", "uniform", 80.0, Some(1.256), Some(0.82)),
    ("glass", "adaptive", 80.0, Some(1.052), Some(0.82)),
    ("curtain", "uniform", 30.0, Some(1.134), Some(0.79)),
    ("curtain", "adaptive", 70.0, Some(1.141), Some(0.79)),
    ("vegetation", "uniform", 40.0, Some(1.292), Some(0.84)),
    ("vegetation", "adaptive", 80.0, Some(1.072), Some(0.84)),
    ("thicket", "uniform", 60.0, Some(1.248), Some(0.74)),
    ("thicket", "adaptive", 70.0, Some(1.146), Some(0.74)),
];

/// The paper's row for a scenario and method.
pub fn lidar_of(scenario: &str, method: &str) -> Option<&'static LidarRow> {
    LIDAR.iter().find(|row| row.0 == scenario && row.1 == method)
}
