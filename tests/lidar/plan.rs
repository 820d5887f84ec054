//! Plan maps of analytic scenes.

use limpid::Config;
use limpid::lidar::CellClass;

use crate::support::gpu::skipped;
use crate::support::scan::{cell, point, run_one, scan, still};

/// A small map: 8 m, 80 cells a side.
fn small() -> Config {
    Config { scan_map_size_m: 8.0, ..Config::default() }
}

#[test]
fn truth_solid_passable_free_and_unknown() {
    if skipped() {
        return;
    }
    // A bright thing ahead, a dim one to the left, no beam behind.
    let mut points = vec![point([2.05, 0.05, 0.2], 200.0), point([0.05, 2.05, -0.2], 40.0)];
    points.push(point([2.05, 0.05, -0.3], 100.0));
    // A dim wall farther ahead, so that beams cross what lies before it.
    points.extend((-100..=100).map(|step| point([3.55, 0.01 * f64::from(step), 0.1], 30.0)));
    let out = run_one(&small(), &still(scan(0, points)));
    let class = |x, y| out.classes[cell(&out, x, y)];
    assert_eq!(class(2.05, 0.05), CellClass::Solid as u8);
    assert_eq!(class(0.05, 2.05), CellClass::Passable as u8);
    assert_eq!(class(0.55, 0.01), CellClass::Free as u8);
    assert_eq!(class(-1.0, 0.0), CellClass::Unknown as u8);
    assert_eq!(class(3.85, 0.05), CellClass::Unknown as u8, "behind it");
    assert_eq!(class(1.55, 0.05), CellClass::Inflated as u8, "towards the robot, away from the goal ahead");
    assert_eq!(out.costmap[cell(&out, 2.05, 0.05)], 254);
    assert_eq!(out.costmap[cell(&out, 0.05, 2.05)], 50);
    assert_eq!(out.costmap[cell(&out, -1.0, 0.0)], 255);
}
