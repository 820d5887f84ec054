//! Scans of analytic scenes, and a scan pipeline that runs them one at a time.

use limpid::Config;
use limpid::lidar::{ScanFrame, ScanOptions, ScanOutput, ScanPipeline, ScanPose};
use limpid::sensor::{Columns, Dropped, Point, ReturnType, Scan, Strength};

/// A point with neither ring nor time.
pub(crate) fn point([x, y, z]: [f64; 3], intensity: f64) -> Point {
    Point {
        x_m: x as f32,
        y_m: y as f32,
        z_m: z as f32,
        intensity: intensity as f32,
        time_s: 0.0,
        ring: Point::UNKNOWN,
        column: Point::UNKNOWN,
        return_type: ReturnType::Single,
        strength: Strength::Unknown,
        reserved: 0,
        label: Point::UNLABELLED,
    }
}

/// Scan `index` of 10 Hz.
pub(crate) fn scan(index: u64, points: Vec<Point>) -> Scan {
    let columns = Columns { ring: points.iter().any(|p| p.ring != Point::UNKNOWN), ..Columns::default() };
    Scan {
        index,
        stamp_ns: 1_700_000_000_000_000_000 + index * 100_000_000,
        frame_id: "lidar".into(),
        points,
        columns,
        dropped: Dropped::default(),
    }
}

/// With the map in the lidar's own frame.
pub(crate) fn still(scan: Scan) -> ScanFrame {
    ScanFrame { scan, map_frame: "lidar".into(), pose: Some(ScanPose::SENSOR), goal_m: None }
}

/// With the lidar at `pose`.
pub(crate) fn posed(scan: Scan, pose: ScanPose) -> ScanFrame {
    ScanFrame { scan, map_frame: "map".into(), pose: Some(pose), goal_m: None }
}

/// Everything read back.
pub(crate) fn open(config: &Config, first: &ScanFrame) -> ScanPipeline {
    let options = ScanOptions { layers: true, ..ScanOptions::default() };
    ScanPipeline::open(config, first, &options).unwrap()
}

/// Submits a scan and waits for it.
pub(crate) fn step(pipeline: &mut ScanPipeline, frame: &ScanFrame) -> ScanOutput {
    pipeline.submit(frame).unwrap();
    pipeline.receive().unwrap().unwrap()
}

/// The result of one scan.
pub(crate) fn run_one(config: &Config, frame: &ScanFrame) -> ScanOutput {
    step(&mut open(config, frame), frame)
}

/// Index of the cell at (x, y) in the map.
pub(crate) fn cell(out: &ScanOutput, x: f64, y: f64) -> usize {
    let at = |m: f64, origin: f64| ((m - origin) / out.grid.resolution_m).floor() as usize;
    at(y, out.grid.origin_y_m) * out.grid.width as usize + at(x, out.grid.origin_x_m)
}

/// A grid beside the plan map.
pub(crate) fn grid<'a>(out: &'a ScanOutput, name: &str) -> &'a [f32] {
    &out.layers.as_ref().unwrap().grids.iter().find(|(known, _)| known == name).unwrap().1
}
