//! Plan maps of analytic scenes.

use limpid::Config;
use limpid::config::LayerMeasure;
use limpid::map::CellClass;

use crate::support::gpu::skipped;
use crate::support::scan::{by_intensity, cell, grid, point, run_one, scan, still};

/// A small map: 8 m, 80 cells a side.
fn small() -> Config {
    Config { scan_map_size_m: 8.0, ..by_intensity() }
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

#[test]
fn truth_the_sum_is_that_of_the_paper() {
    if skipped() {
        return;
    }
    // Three returns of half of full scale in a cell of 0.1 m: 1.5 over 0.01 m2.
    let scan = scan(0, vec![point([2.05, 0.05, 0.2], 127.5); 3]);
    let sum = |gamma: f64| Config { layer_measure: LayerMeasure::Sum, gamma: Some(gamma), ..small() };
    let out = run_one(&sum(149.0), &still(scan.clone()));
    let at = cell(&out, 2.05, 0.05);
    assert!((grid(&out, "intensity_1")[at] - 150.0).abs() < 0.1, "{}", grid(&out, "intensity_1")[at]);
    assert!((grid(&out, "true_positive")[at] - 150.0).abs() < 0.1);
    assert_eq!((out.classes[at], out.costmap[at]), (CellClass::Solid as u8, 254));
    let out = run_one(&sum(151.0), &still(scan));
    assert_eq!(out.classes[at], CellClass::Passable as u8);
    assert!((grid(&out, "false_positive")[at] - 150.0).abs() < 0.1);
}

#[test]
fn truth_the_expected_measure_does_not_fall_with_range() {
    if skipped() {
        return;
    }
    let (azimuth_step_deg, elevation_step_deg) = (0.25, 0.5);
    // Beams on a wall of 0.8 of full scale, `away` metres ahead.
    let wall = |away: f64| {
        let azimuths = (-80..=80).map(|step| f64::from(step) * azimuth_step_deg);
        let points = azimuths.flat_map(|azimuth| {
            let (sin, cos) = azimuth.to_radians().sin_cos();
            (-30..=30).map(move |step| {
                let up = (f64::from(step) * elevation_step_deg).to_radians().tan();
                point([away, away * sin / cos, away / cos * up], 204.0)
            })
        });
        still(scan(0, points.collect()))
    };
    let mean = |layer_measure: LayerMeasure, away: f64| {
        let config = Config {
            layer_measure,
            scan_map_size_m: 16.0,
            layer_heights_m: vec![-1.0, 0.0, 1.0],
            azimuth_step_deg,
            elevation_step_deg,
            elevation_range_deg: [-15.0, 15.0],
            ..by_intensity()
        };
        let out = run_one(&config, &wall(away));
        let value = |step: i32| grid(&out, "intensity_1")[cell(&out, away, f64::from(step) * 0.1 + 0.05)];
        f64::from((-8..8).map(value).sum::<f32>()) / 16.0
    };
    for away in [3.05, 6.05] {
        let expected = mean(LayerMeasure::Expected, away);
        assert!((expected - 0.8).abs() < 0.08, "{expected} at {away} m");
        assert!((mean(LayerMeasure::Mean, away) - 0.8).abs() < 1e-3);
    }
    let fall = mean(LayerMeasure::Sum, 3.05) / mean(LayerMeasure::Sum, 6.05);
    assert!(fall > 2.0, "the control: the sum falls, by {fall}");
}
