//! Mirror images in a polished floor, on an analytic hall: which points are images follows from how its rays were cast.

use glam::DVec3;
use limpid::Config;
use limpid::config::GroundSource;
use limpid::map::glass::PointClass;
use limpid::offline::labeller::Labeller;
use limpid::sensor::Scan;

use super::{alone, label};
use crate::reference::floor_images::Cells;
use crate::support::gpu::skipped;
use crate::support::scan::{point, scan};

const COLUMNS: u16 = 720;
const RINGS: u16 = 32;
/// The lidar above the floor.
const EYE_M: f64 = 0.6;
/// The hall about the lidar: half its length and width, and the ceiling above the lidar.
const HALF_M: [f64; 2] = [5.0, 3.5];
const CEILING_M: f64 = 2.2;
/// What lies ahead lower than the floor, from x to x and to both sides.
const PIT_X_M: [f64; 2] = [1.6, 3.4];
const PIT_HALF_M: f64 = 1.2;
const PIT_M: f64 = 0.8;

/// How the floor is.
#[derive(Clone, Copy, PartialEq)]
enum Floor {
    Matt,
    /// Half of the beams see its images, four side by side.
    Polished,
    /// Matt, with a pit.
    Pit,
}

fn way(ring: u16, column: u16) -> DVec3 {
    let elevation = (-30.0 + 40.0 * f64::from(ring) / f64::from(RINGS - 1)).to_radians();
    let azimuth = std::f64::consts::TAU * f64::from(column) / f64::from(COLUMNS);
    DVec3::new(elevation.cos() * azimuth.cos(), elevation.cos() * azimuth.sin(), elevation.sin())
}

/// How far a ray goes to the box that reaches so far below the lidar and above it.
fn to_box(way: DVec3, half_m: [f64; 2], low_m: f64, high_m: f64) -> f64 {
    let z = if way.z < 0.0 { low_m / -way.z } else { high_m / way.z.max(1e-9) };
    z.min(half_m[0] / way.x.abs().max(1e-9)).min(half_m[1] / way.y.abs().max(1e-9))
}

/// Where a beam ends, and whether that is an image.
fn end(floor: Floor, ring: u16, column: u16) -> (DVec3, bool) {
    let way = way(ring, column);
    let direct = way * to_box(way, HALF_M, EYE_M, CEILING_M);
    let on_floor = (direct.z + EYE_M).abs() < 1e-9;
    if floor == Floor::Polished && on_floor && (column + 3 * ring) % 8 < 4 {
        // The room below the floor is as high as the one above.
        return (way * to_box(way, HALF_M, 2.0 * EYE_M + CEILING_M, CEILING_M), true);
    }
    let over_pit = (PIT_X_M[0]..PIT_X_M[1]).contains(&direct.x) && direct.y.abs() < PIT_HALF_M;
    if floor == Floor::Pit && on_floor && over_pit {
        let bottom = (EYE_M + PIT_M) / -way.z;
        let walls = (PIT_X_M[1] / way.x.max(1e-9)).min(PIT_HALF_M / way.y.abs().max(1e-9));
        return (way * bottom.min(walls), false);
    }
    (direct, false)
}

fn hall(floor: Floor) -> (Scan, Vec<bool>) {
    let beams = (0..RINGS).flat_map(|ring| (0..COLUMNS).map(move |column| (ring, column)));
    let (points, images) = beams
        .map(|(ring, column)| {
            let (at, image) = end(floor, ring, column);
            let mut point = point(at.to_array(), 20.0);
            point.ring = ring;
            (point, image)
        })
        .unzip();
    (scan(0, points), images)
}

/// Which points are called a reflection without a pane.
fn called(config: &Config, scan: &Scan) -> Vec<bool> {
    let labelled = label(config, scan);
    let reflections = labelled.classes.iter().filter(|(class, _)| *class == PointClass::Reflection).count();
    assert_eq!(labelled.counters.classes[PointClass::Reflection as usize] as usize, reflections);
    assert_eq!(labelled.counters.classes.iter().sum::<u32>() as usize, scan.points.len());
    labelled.classes.iter().map(|label| *label == (PointClass::Reflection, 0)).collect()
}

fn count(called: &[bool], of: impl Fn(usize) -> bool) -> [usize; 2] {
    let numbers = || (0..called.len()).filter(|number| of(*number));
    [numbers().filter(|number| called[*number]).count(), numbers().count()]
}

#[test]
fn truth_images_in_a_polished_floor_are_reflections() {
    if skipped() {
        return;
    }
    let (scan, images) = hall(Floor::Polished);
    let found = called(&alone(), &scan);
    let deep = |number: usize| images[number] && f64::from(scan.points[number].z_m) < -EYE_M - 0.25;
    let [right, all] = count(&found, deep);
    assert!(all > 3000 && right * 100 > all * 98, "{right} of {all}");
    let [wrong, real] = count(&found, |number| !images[number]);
    assert_eq!(wrong, 0, "of {real}");
    let stated = Config { ground: GroundSource::Stated, ..alone() };
    assert_eq!(count(&called(&stated, &scan), |_| true)[0], 0, "a floor that is only stated");
}

#[test]
fn truth_a_pit_and_a_matt_floor_have_no_images() {
    if skipped() {
        return;
    }
    for floor in [Floor::Pit, Floor::Matt] {
        let (scan, _) = hall(floor);
        let deep = scan.points.iter().filter(|point| f64::from(point.z_m) < -EYE_M - 0.3).count();
        assert_eq!(deep > 300, floor == Floor::Pit, "{deep}");
        assert_eq!(count(&called(&alone(), &scan), |_| true)[0], 0, "of {deep} below the floor");
    }
}

#[test]
fn floor_images_are_as_the_twin_finds_them() {
    if skipped() {
        return;
    }
    for floor in [Floor::Polished, Floor::Pit] {
        let (scan, _) = hall(floor);
        let (found, config) = (called(&alone(), &scan), alone());
        let labeller = Labeller::open(&config, &scan, None, false).unwrap();
        let at = |number: usize| {
            let point = &scan.points[number];
            (DVec3::from(point.position_m().map(f64::from)), usize::from(point.ring))
        };
        let points: Vec<_> = (0..scan.points.len()).map(at).collect();
        let cells = Cells::new(labeller.grid(), &config, &points);
        let same = points.iter().zip(&found);
        let same = same.filter(|((at, ring), found)| cells.is_image(*at, *ring, EYE_M) == **found).count();
        // The floor as it was estimated lies a little off, and decides at its limits.
        assert!(same * 1000 >= found.len() * 998, "{same} of {}", found.len());
    }
}
