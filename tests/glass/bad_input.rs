//! What may be wrong with a scan has a counter or an error, and never more than a pane too few.

use limpid::Config;
use limpid::base::Rigid;
use limpid::map::glass::PointClass;
use limpid::offline::labeller::Labeller;
use limpid::sensor::BeamGrid;
use limpid::sensor::{Point, ReturnType, Scan};

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
    let farther: Vec<Point> = scan.points.iter().map(|point| scaled(point, 2.0)).collect();
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
fn points_without_a_ring_are_placed_by_their_elevation() {
    if skipped() {
        return;
    }
    let (mut scan, truth) = GlassRoom::default().scan();
    scan.points.iter_mut().step_by(3).for_each(|point| point.ring = Point::UNKNOWN);
    let labelled = label(&alone(), &scan);
    assert_eq!((labelled.counters.points_without_row, labelled.panes.len()), (0, 1));
    for class in [PointClass::Inside, PointClass::Glass] {
        assert_eq!(super::wrong(&labelled, &truth, class)[1..], [0, 0], "{class:?}");
    }
    // The control: none of the rows goes straight up.
    (scan.points[0].x_m, scan.points[0].y_m, scan.points[0].z_m) = (0.1, 0.0, 3.0);
    let grid = BeamGrid::of_scan(&GlassRoom::default().scan().0).unwrap();
    assert_eq!(grid.elevation_rows.last(), Some(&u32::MAX));
    let mut labeller = Labeller::open(&alone(), &GlassRoom::default().scan().0, None, false).unwrap();
    assert_eq!(labeller.label(&scan, Rigid::IDENTITY).unwrap().counters.points_without_row, 1);
}

/// The room's wall as all there is: every beam that goes forward ends on the plane of the pane; and what lies behind it
/// by `behind_m`, as a last return.
fn one_plane(behind_m: Option<f32>) -> Scan {
    let (mut scan, _) = GlassRoom { glass: false, yaw: 0.0, ..GlassRoom::default() }.scan();
    scan.points.retain(|point| point.x_m > 1.0);
    scan.points.iter_mut().for_each(|point| {
        let share = 4.0 / point.x_m;
        (point.x_m, point.y_m, point.z_m) = (4.0, share * point.y_m, share * point.z_m);
    });
    if let Some(behind_m) = behind_m {
        let share = 1.0 + behind_m / 4.0;
        let last: Vec<Point> = scan.points.iter().map(|point| scaled(point, share)).collect();
        scan.points.extend(last);
    }
    scan
}

fn scaled(point: &Point, share: f32) -> Point {
    Point {
        x_m: share * point.x_m,
        y_m: share * point.y_m,
        z_m: share * point.z_m,
        return_type: ReturnType::Last,
        ..*point
    }
}

#[test]
fn all_points_on_one_plane_are_no_glass() {
    if skipped() {
        return;
    }
    // Both returns of every beam on it: none differs, so there is no candidate.
    for scan in [one_plane(None), one_plane(Some(0.02))] {
        let labelled = label(&alone(), &scan);
        assert_eq!((labelled.counters.candidates, labelled.panes.len()), (0, 0), "{:?}", labelled.counters);
        assert_eq!(labelled.counters.classes[PointClass::Inside as usize] as usize, scan.points.len());
    }
    // Two planes that every beam meets, at whatever slant: glass does not show at 70 degrees.
    let labelled = label(&alone(), &one_plane(Some(1.0)));
    assert!(labelled.panes.is_empty() && labelled.counters.refused_planes == 1, "{:?}", labelled.counters);
    // The control: of two planes that show within 29 degrees of head on the nearer is a pane.
    let mut scan = one_plane(Some(1.0));
    scan.points.retain(|point| point.y_m.hypot(point.z_m) < 0.55 * point.x_m);
    let labelled = label(&alone(), &scan);
    assert!(labelled.counters.candidates > 1000 && labelled.panes.len() == 1, "{:?}", labelled.counters);
}

#[test]
fn candidates_in_one_line_make_no_plane() {
    if skipped() {
        return;
    }
    let mut scan = one_plane(Some(1.0));
    let ring = scan.points[scan.points.len() / 4].ring;
    scan.points.retain(|point| point.ring == ring);
    let labelled = label(&alone(), &scan);
    assert!(labelled.counters.candidates > 50 && labelled.panes.is_empty(), "{:?}", labelled.counters);
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
