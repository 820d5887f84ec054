//! What may be wrong with a scan has a counter or an error, and never more than a pane too few.

use limpid::Config;
use limpid::geometry::Rigid;
use limpid::glass::{BeamGrid, Labeller, PointClass};
use limpid::recording::points::{Point, ReturnType};

use super::{alone, label};
use crate::support::glass_room::GlassRoom;
use crate::support::gpu::skipped;

#[test]
fn points_that_are_no_numbers_are_counted_and_not_labelled() {
    if skipped() {
        return;
    }
    let (mut scan, _) = GlassRoom::default().scan();
    let whole = label(&alone(), &scan);
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30, f32::MAX, 0.0];
    for (point, bad) in scan.points.iter_mut().step_by(97).zip(bad.iter().cycle()) {
        (point.x_m, point.y_m, point.z_m) = (*bad, 0.0, 0.0);
    }
    let bad_count = scan.points.len().div_ceil(97);
    let labelled = label(&alone(), &scan);
    assert_eq!(labelled.counters.unusable_points as usize, bad_count);
    assert_eq!(labelled.panes.len(), whole.panes.len());
    let of_bad: Vec<_> = labelled.classes.iter().step_by(97).collect();
    assert!(of_bad.iter().all(|(class, pane)| *class == PointClass::Unlabelled && *pane == 0));
}

#[test]
fn without_intensity_everything_on_the_pane_is_glass() {
    if skipped() {
        return;
    }
    let (mut scan, truth) = GlassRoom::default().scan();
    scan.points.iter_mut().for_each(|point| point.intensity = 0.0);
    let labelled = label(&alone(), &scan);
    assert_eq!(labelled.panes.len(), 1);
    assert_eq!(labelled.panes[0].level.w, 0.0, "no limit is known");
    assert_eq!(super::wrong(&labelled, &truth, PointClass::Glass)[1], 0);
}

#[test]
fn without_second_returns_and_intensities_there_is_nothing_to_find() {
    if skipped() {
        return;
    }
    let (mut scan, _) = GlassRoom { single: true, ..GlassRoom::default() }.scan();
    scan.points.iter_mut().for_each(|point| {
        point.intensity = 0.0;
        point.return_type = ReturnType::Single;
    });
    let labelled = label(&alone(), &scan);
    assert_eq!((labelled.counters.candidates, labelled.panes.len()), (0, 0));
}

#[test]
fn candidates_beyond_what_is_looked_at_are_counted() {
    if skipped() {
        return;
    }
    let (mut scan, _) = GlassRoom { glass: false, ..GlassRoom::default() }.scan();
    let farther: Vec<Point> = scan
        .points
        .iter()
        .map(|point| Point {
            x_m: 2.0 * point.x_m,
            y_m: 2.0 * point.y_m,
            z_m: 2.0 * point.z_m,
            return_type: ReturnType::Last,
            ..*point
        })
        .collect();
    scan.points.extend(farther);
    let counters = label(&alone(), &scan).counters;
    assert!(counters.dual_returns > 20_000, "{counters:?}");
    assert_eq!(counters.candidates, counters.dual_returns);
    assert!(counters.thinned_candidates + 4096 >= counters.candidates, "{counters:?}");
}

#[test]
fn a_wall_of_single_returns_and_a_mirror_are_no_glass() {
    if skipped() {
        return;
    }
    let (scan, _) = GlassRoom { mirror: true, ..GlassRoom::default() }.scan();
    let labelled = label(&alone(), &scan);
    assert!(labelled.panes.is_empty(), "a mirror has no return of its own: {:?}", labelled.counters);
}

#[test]
fn rings_outside_the_first_scan_are_counted() {
    if skipped() {
        return;
    }
    let (scan, _) = GlassRoom::default().scan();
    let mut labeller = Labeller::open(&alone(), &scan, None, false).unwrap();
    let mut strange = scan.clone();
    strange.points.iter_mut().take(10).for_each(|point| point.ring = 200);
    let labelled = labeller.label(&strange, Rigid::IDENTITY).unwrap();
    assert_eq!(labelled.counters.points_without_row, 10);
}

#[test]
fn sizes_from_one_point_on() {
    if skipped() {
        return;
    }
    let (scan, _) = GlassRoom::default().scan();
    for count in [1, 63, 64, 65] {
        let mut few = scan.clone();
        few.points.truncate(count);
        let labelled = label(&alone(), &few);
        assert_eq!(labelled.classes.len(), count);
        assert!(labelled.panes.is_empty());
    }
    let mut labeller = Labeller::open(&alone(), &scan, None, false).unwrap();
    let mut none = scan.clone();
    none.points.clear();
    assert!(labeller.label(&none, Rigid::IDENTITY).unwrap().classes.is_empty());
    let error = BeamGrid::of_scan(&none).unwrap_err().to_string();
    assert!(error.contains("no usable point"), "{error}");
}

#[test]
fn more_points_than_before_are_taken() {
    if skipped() {
        return;
    }
    let (scan, _) = GlassRoom::default().scan();
    let mut few = scan.clone();
    few.points.truncate(9000);
    let config = Config::default();
    let mut labeller = Labeller::open(&config, &few, None, false).unwrap();
    assert_eq!(labeller.label(&scan, Rigid::IDENTITY).unwrap().classes.len(), scan.points.len());
}

#[test]
fn impossible_parameters_are_refused_by_name() {
    for (key, config) in [
        ("glass_match_m", Config { glass_match_m: 0.0, ..alone() }),
        ("glass_hypotheses", Config { glass_hypotheses: 1_000_000, ..alone() }),
        ("glass_lobe_deg", Config { glass_lobe_deg: f64::NAN, ..alone() }),
        ("glass_match_per_m", Config { glass_match_per_m: -1.0, ..alone() }),
    ] {
        let error = config.validate().unwrap_err().to_string();
        assert!(error.contains(key), "{error}");
    }
}
