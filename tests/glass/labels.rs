//! The analytic room.

use glam::{DVec3, Vec3};
use limpid::map::Pane;
use limpid::map::glass::{LabelledScan, PointClass};
use limpid::sensor::Point;

use super::{alone, label, wrong};
use crate::support::glass_room::GlassRoom;
use crate::support::gpu::skipped;

/// Degrees between normals and metres between planes.
fn off(pane: &Pane, (normal, distance_m): (DVec3, f64)) -> (f64, f64) {
    let cos = pane.unit_normal().as_dvec3().normalize().dot(normal);
    (cos.clamp(-1.0, 1.0).acos().to_degrees(), (f64::from(pane.normal.w) - distance_m).abs())
}

fn assert_room(labelled: &LabelledScan, room: &GlassRoom) {
    assert_eq!(labelled.panes.len(), 1, "{:?}", labelled.panes);
    let (degrees, metres) = off(&labelled.panes[0], room.plane());
    assert!(degrees < 0.2 && metres < 0.01, "{degrees} degrees, {metres} m");
    let [u0, u1, v0, v1] = labelled.panes[0].extent_m.to_array();
    assert!((3.0..5.0).contains(&(u1 - u0)) && (1.8..3.2).contains(&(v1 - v0)), "{u0} {u1} {v0} {v1}");
}

#[test]
fn truth_every_class_is_right_away_from_edges() {
    if skipped() {
        return;
    }
    for yaw in [0.0, 0.4, 2.0, -1.1] {
        let room = GlassRoom { yaw, ..GlassRoom::default() };
        let (scan, truth) = room.scan();
        let labelled = label(&alone(), &scan);
        assert_room(&labelled, &room);
        for class in [PointClass::Inside, PointClass::Glass, PointClass::Reflection, PointClass::Outside] {
            let [all, wrong, open] = wrong(&labelled, &truth, class);
            assert!(all > 40, "{all} of {class:?}");
            assert_eq!(wrong, 0, "yaw {yaw}, {class:?}: {wrong} of {all}");
            assert!(50 * open <= all, "yaw {yaw}, {class:?}: {open} of {all} undecided");
        }
    }
}

#[test]
fn control_a_wrong_class_is_noticed() {
    let (_, truth) = GlassRoom::default().scan();
    let swapped = |class| match class {
        PointClass::Outside => PointClass::Reflection,
        other => other,
    };
    let classes = truth.iter().map(|t| (swapped(t.class), 1)).collect();
    let labelled = LabelledScan { classes, panes: vec![], counters: Default::default(), pass_ms: vec![] };
    assert_eq!(wrong(&labelled, &truth, PointClass::Reflection)[1], 0);
    let [all, wrong, _] = wrong(&labelled, &truth, PointClass::Outside);
    assert!(all > 60 && wrong == all);
}

#[test]
fn truth_mirrored_points_lie_on_the_real_surfaces() {
    let room = GlassRoom { yaw: 0.0, ..GlassRoom::default() };
    let pane = Pane {
        normal: Vec3::X.extend(3.7),
        level: Vec3::Y.extend(0.0),
        extent_m: glam::Vec4::new(-2.0, 2.0, -0.9, 1.4),
        id: 1,
        hits: 1,
        misses: 0,
        age: 1,
    };
    let (scan, truth) = room.scan();
    let mut count = 0;
    for (point, _) in scan.points.iter().zip(&truth).filter(|(_, t)| t.class == PointClass::Reflection) {
        let place = pane.mirrored_m(DVec3::from(point.position_m().map(f64::from))) + room.sensor_m;
        let walls = [place.x + 4.0, place.y - 3.5, place.y + 3.5, place.z - 1.8, place.z + 1.2];
        let cupboard = [place.x + 3.0, place.y - 1.5, place.z - 0.9];
        let nearest = walls.iter().chain(&cupboard).map(|off| off.abs()).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-3, "{place} is {nearest} m from all surfaces");
        count += 1;
    }
    assert!(count > 100);
}

#[test]
fn truth_without_glass_there_is_no_pane() {
    if skipped() {
        return;
    }
    let (scan, _) = GlassRoom { glass: false, ..GlassRoom::default() }.scan();
    let labelled = label(&alone(), &scan);
    assert!(labelled.panes.is_empty());
    assert!(labelled.classes.iter().all(|(class, pane)| *class == PointClass::Inside && *pane == 0));
    assert_eq!(labelled.counters.classes[PointClass::Inside as usize] as usize, scan.points.len());
}

#[test]
fn truth_a_single_return_finds_the_pane_by_its_peak() {
    if skipped() {
        return;
    }
    let room = GlassRoom { single: true, ..GlassRoom::default() };
    let (scan, truth) = room.scan();
    let labelled = label(&alone(), &scan);
    assert_eq!(labelled.counters.dual_returns, 0);
    assert!(labelled.counters.peak_points > 20, "{:?}", labelled.counters);
    assert_eq!(labelled.panes.len(), 1, "{:?}", labelled.counters);
    let (degrees, metres) = off(&labelled.panes[0], room.plane());
    assert!(degrees < 0.2 && metres < 0.01, "{degrees} degrees, {metres} m");
    let [all, wrong, _] = wrong(&labelled, &truth, PointClass::Glass);
    assert!(all > 100 && wrong == 0, "{wrong} of {all}");
}

#[test]
fn truth_a_wall_that_shines_head_on_and_stops_slanting_beams_is_no_pane() {
    if skipped() {
        return;
    }
    let room = GlassRoom { single: true, yaw: 0.0, ..GlassRoom::default() };
    let (mut scan, truth) = room.scan();
    assert_eq!(label(&alone(), &scan).panes.len(), 1, "the control: glass");
    // Where glass lets beams through, a wall with the same shine returns them, but for a door at its end.
    let (normal, distance_m) = room.plane();
    for (point, truth) in scan.points.iter_mut().zip(&truth) {
        let along_m = normal.dot(DVec3::from(point.position_m().map(f64::from)));
        let share = (distance_m / along_m) as f32;
        if truth.class != PointClass::Inside && truth.class != PointClass::Glass && share * point.y_m < 1.5 {
            (point.x_m, point.y_m, point.z_m) = (share * point.x_m, share * point.y_m, share * point.z_m);
        }
    }
    let labelled = label(&alone(), &scan);
    assert!(labelled.panes.is_empty() && labelled.counters.refused_planes == 1, "{:?}", labelled.counters);
}

#[test]
fn truth_a_bright_face_between_dark_ones_is_no_peak() {
    if skipped() {
        return;
    }
    let room = GlassRoom { glass: false, single: true, yaw: 0.0, ..GlassRoom::default() };
    let scan = |brightness: &dyn Fn(f64) -> f64| {
        let (mut scan, _) = room.scan();
        for point in &mut scan.points {
            let degrees = f64::from(point.y_m).atan2(f64::from(point.x_m)).to_degrees();
            point.intensity = brightness(degrees) as f32;
        }
        label(&alone(), &scan).counters
    };
    let face = scan(&|degrees| if degrees.abs() < 7.0 { 200.0 } else { 40.0 });
    assert_eq!(face.peak_points, 0, "{face:?}");
    let lobe = scan(&|degrees| 40.0 + 160.0 * (-(degrees / 6.0).powi(2)).exp());
    assert!(lobe.peak_points > 20, "the control: {lobe:?}");
}

#[test]
fn the_same_scan_gives_the_same_bits_and_the_order_of_points_does_not_matter() {
    if skipped() {
        return;
    }
    let (mut scan, _) = GlassRoom::default().scan();
    let first = label(&alone(), &scan);
    assert_eq!(label(&alone(), &scan), first);
    scan.points.reverse();
    let mut reversed = label(&alone(), &scan);
    reversed.classes.reverse();
    assert_eq!(reversed.classes, first.classes);
    assert_eq!(reversed.panes, first.panes);
}

#[test]
fn without_rings_elevations_give_the_rows() {
    if skipped() {
        return;
    }
    let room = GlassRoom::default();
    let (mut scan, _) = room.scan();
    scan.columns.ring = false;
    scan.points.iter_mut().for_each(|point| point.ring = Point::UNKNOWN);
    let labelled = label(&alone(), &scan);
    assert_eq!(labelled.panes.len(), 1);
    let (degrees, metres) = off(&labelled.panes[0], room.plane());
    assert!(degrees < 0.2 && metres < 0.01, "{degrees} degrees, {metres} m");
}
