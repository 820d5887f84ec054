//! Mirrors, on an analytic hall: what lies behind its opening follows from how its rays were cast.

use glam::DVec3;
use limpid::Config;
use limpid::base::Rigid;
use limpid::map::glass::{LabelledScan, PointClass};
use limpid::offline::labeller::Labeller;

use super::{alone, label};
use crate::support::gpu::skipped;
use crate::support::mirror_hall::{OPENING, Opening, WALL_X_M, hall, in_lidar};

/// Of the points behind the opening, or of the others: how many are of a class, and how many there are.
fn count(labelled: &LabelledScan, behind: &[bool], through: bool, class: PointClass) -> [usize; 2] {
    let of = labelled.classes.iter().zip(behind).filter(|(_, behind)| **behind == through);
    of.fold([0; 2], |[called, all], ((kind, _), _)| [called + usize::from(*kind == class), all + 1])
}

#[test]
fn truth_a_mirror_is_found_with_its_ends_and_all_behind_it_is_a_reflection() {
    if skipped() {
        return;
    }
    let (scan, behind) = hall(Opening::Mirror, true);
    let labelled = label(&alone(), &scan);
    assert_eq!((labelled.counters.found_mirrors, labelled.counters.found_panes), (1, 0));
    let [mirror] = labelled.panes[..] else { panic!("{:?}", labelled.panes) };
    assert!(mirror.is_mirror());
    let normal = in_lidar(DVec3::X).as_vec3();
    assert!(mirror.unit_normal().dot(normal) > 0.9999 && (mirror.normal.w - WALL_X_M as f32).abs() < 0.02);
    let corners = mirror.corners_m().map(|corner| [in_lidar(DVec3::Y).dot(corner), corner.z]);
    for (axis, ends) in OPENING.into_iter().enumerate() {
        let least = corners.iter().map(|c| c[axis]).fold(f64::INFINITY, f64::min);
        let largest = corners.iter().map(|c| c[axis]).fold(f64::NEG_INFINITY, f64::max);
        assert!((least - ends[0]).abs() < 0.15 && (largest - ends[1]).abs() < 0.15, "{least} {largest}");
    }
    let [reflections, all] = count(&labelled, &behind, true, PointClass::Reflection);
    assert!(all > 2500 && reflections * 100 > all * 98, "{reflections} of {all}");
    let [wrong, before] = count(&labelled, &behind, false, PointClass::Reflection);
    assert!(wrong < 20, "{wrong} of {before}");
    // Mirrored back they lie in the hall.
    let back =
        scan.points.iter().zip(&labelled.classes).filter(|(_, (class, _))| *class == PointClass::Reflection);
    let inside = back.map(|(point, _)| mirror.mirrored_m(DVec3::from(point.position_m().map(f64::from))));
    assert!(inside.into_iter().all(|at| in_lidar(DVec3::X).dot(at) > -4.1 && at.z > -0.7));
}

#[test]
fn truth_doors_and_walls_are_no_mirrors() {
    if skipped() {
        return;
    }
    // The side walls, floor and ceiling of each room go on behind the door, where a mirror would have them. (A room that is as deep as the
    // hall, too, is its image.)
    for opening in [Opening::Wall, Opening::Door(3.0), Opening::Door(5.0), Opening::Door(30.0)] {
        let (scan, behind) = hall(opening, true);
        let labelled = label(&alone(), &scan);
        assert!(labelled.panes.is_empty() && labelled.counters.found_mirrors == 0, "{opening:?}");
        assert_eq!(
            count(&labelled, &behind, true, PointClass::Inside)[0],
            behind.iter().filter(|b| **b).count()
        );
    }
}

#[test]
fn mirrors_are_looked_for_where_two_returns_tell_glass_apart_and_where_wanted() {
    if skipped() {
        return;
    }
    let (single, _) = hall(Opening::Mirror, false);
    assert!(label(&alone(), &single).panes.is_empty());
    let (dual, _) = hall(Opening::Mirror, true);
    assert!(label(&Config { glass_mirrors: false, ..alone() }, &dual).panes.is_empty());
}

#[test]
fn a_mirror_is_kept_while_it_is_not_refuted() {
    if skipped() {
        return;
    }
    let config = Config::default();
    let (mirror, behind) = hall(Opening::Mirror, true);
    let mut labeller = Labeller::open(&config, &mirror, None, false).unwrap();
    for _ in 0..3 {
        labeller.label(&mirror, Rigid::IDENTITY).unwrap();
    }
    // One return a beam shows no mirror, but it is known by now.
    let (single, _) = hall(Opening::Mirror, false);
    let labelled = labeller.label(&single, Rigid::IDENTITY).unwrap();
    assert_eq!((labelled.counters.found_mirrors, labelled.panes.len(), labelled.panes[0].hits), (0, 1, 3));
    // The points of the second returns are not in it.
    let first: Vec<bool> = mirror
        .points
        .iter()
        .zip(&behind)
        .filter(|(p, _)| p.return_type != limpid::sensor::ReturnType::Last)
        .map(|(_, b)| *b)
        .collect();
    let [reflections, all] = count(&labelled, &first, true, PointClass::Reflection);
    assert!(reflections * 100 > all * 98, "{reflections} of {all}");
    // Through the same place a room that is none of the mirror's: three scans refute it.
    let (door, _) = hall(Opening::Door(3.0), true);
    let left: Vec<usize> =
        (0..4).map(|_| labeller.label(&door, Rigid::IDENTITY).unwrap().panes.len()).collect();
    assert_eq!(left, [1, 1, 1, 0]);
}
