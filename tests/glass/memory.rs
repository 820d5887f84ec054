//! Panes over time.

use glam::{DQuat, DVec3, Vec4};
use limpid::Config;
use limpid::base::Rigid;
use limpid::map::Pane;
use limpid::map::PaneSet;
use limpid::map::glass::PointClass;
use limpid::offline::labeller::Labeller;
use limpid::sensor::{ReturnType, Scan};

use super::wrong;
use crate::support::glass_room::{GlassRoom, Truth};
use crate::support::gpu::skipped;

fn pose(room: &GlassRoom) -> Rigid {
    Rigid { rotation: DQuat::from_rotation_z(room.yaw), translation_m: room.sensor_m }
}

fn set(panes: Vec<Pane>) -> PaneSet {
    PaneSet { panes, ..PaneSet::default() }
}

/// The scan without its first returns on glass, as a sensor that does not see the pane gives it.
pub(super) fn blind((mut scan, truth): (Scan, Vec<Truth>)) -> Scan {
    scan.points.iter_mut().for_each(|point| point.return_type = ReturnType::First);
    let mut truth = truth.iter();
    scan.points.retain(|_| truth.next().is_some_and(|t| t.class != PointClass::Glass));
    scan
}

#[test]
fn truth_a_pane_found_once_labels_scans_that_do_not_show_it() {
    if skipped() {
        return;
    }
    let here = GlassRoom::default();
    let (scan, _) = here.scan();
    let mut labeller = Labeller::open(&Config::default(), &scan, None, false).unwrap();
    let first = labeller.label(&scan, pose(&here)).unwrap();
    assert_eq!((first.panes.len(), first.panes[0].id), (1, 1));
    let there = GlassRoom { yaw: -0.5, sensor_m: DVec3::new(0.9, -0.6, 0.1), ..here };
    let second = blind(there.scan());
    let labelled = labeller.label(&second, pose(&there)).unwrap();
    assert_eq!(labelled.counters.found_panes, 0, "the scan itself does not show it");
    assert_eq!((labelled.panes.len(), labelled.panes[0].id), (1, 1));
    let (normal, distance_m) = there.plane();
    assert!((f64::from(labelled.panes[0].normal.w) - distance_m).abs() < 0.01);
    assert!(labelled.panes[0].unit_normal().as_dvec3().dot(normal) > 0.99999);
    let outside = labelled.classes.iter().filter(|(class, _)| *class == PointClass::Outside).count();
    let reflections = labelled.classes.iter().filter(|(class, _)| *class == PointClass::Reflection).count();
    assert!(outside > 100 && reflections > 100, "{outside} {reflections}");
    // The control: without memory the same scan has no pane and all is inside.
    let config = Config { glass_memory: false, ..Config::default() };
    let mut forgetful = Labeller::open(&config, &scan, None, false).unwrap();
    forgetful.label(&scan, pose(&here)).unwrap();
    assert!(forgetful.label(&second, pose(&there)).unwrap().panes.is_empty());
}

#[test]
fn truth_a_pane_seen_again_is_the_same_and_is_refined() {
    if skipped() {
        return;
    }
    let room = GlassRoom::default();
    let (scan, truth) = room.scan();
    let mut labeller = Labeller::open(&Config::default(), &scan, None, false).unwrap();
    for turn in 1..=4_u32 {
        let labelled = labeller.label(&scan, pose(&room)).unwrap();
        assert_eq!(labelled.panes.len(), 1);
        assert_eq!((labelled.panes[0].id, labelled.panes[0].hits), (1, turn));
        assert_eq!(wrong(&labelled, &truth, PointClass::Reflection)[1], 0);
    }
}

#[test]
fn truth_a_pane_that_beams_pass_through_goes_away() {
    if skipped() {
        return;
    }
    let room = GlassRoom { yaw: 0.0, ..GlassRoom::default() };
    let (scan, _) = room.scan();
    let mut labeller = Labeller::open(&Config::default(), &scan, None, false).unwrap();
    assert_eq!(labeller.label(&scan, pose(&room)).unwrap().panes.len(), 1);
    let open = blind(room.scan());
    let left: Vec<usize> = (0..5).map(|_| labeller.label(&open, pose(&room)).unwrap().panes.len()).collect();
    assert_eq!(left, [1, 1, 1, 0, 0], "three scans in a row prove it absent, each counted in the next");
}

#[test]
fn truth_loaded_panes_replace_all_that_are_kept() {
    if skipped() {
        return;
    }
    let room = GlassRoom::default();
    let (scan, _) = room.scan();
    let mut labeller = Labeller::open(&Config::default(), &scan, None, false).unwrap();
    let pane = labeller.label(&scan, pose(&room)).unwrap().panes[0].moved(pose(&room));
    let away = |metres: f32, id: u32| Pane { normal: pane.normal + Vec4::W * metres, id, ..pane };
    let open = blind(room.scan());
    let mut ids = |load: Option<Vec<Pane>>| {
        load.into_iter().for_each(|panes| labeller.load(set(panes)).unwrap());
        let panes = labeller.label(&open, pose(&room)).unwrap().panes;
        panes.iter().map(|pane| pane.id).collect::<Vec<_>>()
    };
    assert_eq!(ids(None), [1], "the control: it is kept");
    assert_eq!(ids(Some(vec![away(3.0, 4), away(6.0, 5)])), [4, 5]);
    assert_eq!(ids(Some(vec![away(9.0, 7)])), [7]);
    assert!(ids(Some(Vec::new())).is_empty());
    let error = labeller.load(set(vec![pane; 17])).unwrap_err().to_string();
    assert!(error.contains("17; at most 16"), "{error}");
}

#[test]
fn truth_labels_do_not_depend_on_where_the_map_counts_from() {
    if skipped() {
        return;
    }
    let rooms: Vec<_> = (0..4_u8)
        .map(|number| {
            let sensor_m = DVec3::new(0.25 + 0.125 * f64::from(number), 0.1875, 0.0625);
            GlassRoom { yaw: 0.2 * f64::from(number), sensor_m, ..GlassRoom::default() }
        })
        .collect();
    let scans: Vec<_> = rooms.iter().map(GlassRoom::scan).collect();
    let blind_scan = blind(rooms[3].scan());
    let drive = |offset_m: DVec3| {
        let place = |room: &GlassRoom| Rigid { translation_m: room.sensor_m + offset_m, ..pose(room) };
        let mut labeller = Labeller::open(&Config::default(), &scans[0].0, None, false).unwrap();
        let mut labelled: Vec<_> = rooms
            .iter()
            .zip(&scans)
            .map(|(room, (scan, _))| labeller.label(scan, place(room)).unwrap())
            .collect();
        let set = PaneSet::of_scan(&labelled[3].panes, place(&rooms[3]));
        // Started far from the first pane, as another run of the same robot may be.
        labeller.reset().unwrap();
        let far = Rigid { translation_m: offset_m + DVec3::new(64.0, -128.0, 0.0), ..Rigid::IDENTITY };
        labeller.label(&blind_scan, far).unwrap();
        labeller.load(set).unwrap();
        labelled.push(labeller.label(&blind_scan, place(&rooms[3])).unwrap());
        labelled
    };
    let (here, utm) = (drive(DVec3::ZERO), drive(DVec3::new(4.0e5, 5.0e6, 100.0)));
    let hits: Vec<u32> = here[..4].iter().map(|labelled| labelled.panes[0].hits).collect();
    assert_eq!((hits, here[4].panes.len()), (vec![1, 2, 3, 4], 1));
    assert_eq!(here, utm);
}

#[test]
fn a_pose_that_jumps_gives_a_second_pane_and_no_error() {
    if skipped() {
        return;
    }
    let room = GlassRoom::default();
    let (scan, truth) = room.scan();
    let mut labeller = Labeller::open(&Config::default(), &scan, None, false).unwrap();
    assert_eq!(labeller.label(&scan, pose(&room)).unwrap().counters.pose_jumps, 0, "the first never jumps");
    let jumped = Rigid { translation_m: DVec3::new(400.0, -90.0, 3.0), ..pose(&room) };
    let labelled = labeller.label(&scan, jumped).unwrap();
    let near = labelled.panes.iter().filter(|pane| pane.normal.w < 10.0).count();
    assert_eq!((labelled.panes.len(), near), (2, 1));
    assert_eq!(labelled.counters.pose_jumps, 1);
    assert_eq!(wrong(&labelled, &truth, PointClass::Glass)[1], 0);
    let nowhere = Rigid { translation_m: DVec3::splat(f64::NAN), ..Rigid::IDENTITY };
    let error = labeller.label(&scan, nowhere).unwrap_err().to_string();
    assert!(error.contains("pose"), "{error}");
    assert_eq!(
        labeller.label(&scan, jumped).unwrap().counters.pose_jumps,
        0,
        "a pose that is refused is none"
    );
}

#[test]
fn truth_a_grazing_pane_is_not_found_and_a_kept_one_still_labels_by_it() {
    if skipped() {
        return;
    }
    let here = GlassRoom { yaw: 0.0, ..GlassRoom::default() };
    // The pane begins 1.6 m to the side and is 0.5 m away: no beam meets it within 70 degrees of head on.
    let grazing = GlassRoom { sensor_m: DVec3::new(3.5, -3.4, 0.0), ..here };
    let (scan, truth) = grazing.scan();
    assert!(truth.iter().all(|t| t.class != PointClass::Glass), "no beam returns from the glass");
    let alone = super::label(&super::alone(), &scan);
    assert!(alone.panes.is_empty(), "{:?}", alone.counters);
    let mut labeller = Labeller::open(&Config::default(), &here.scan().0, None, false).unwrap();
    labeller.label(&here.scan().0, pose(&here)).unwrap();
    for _ in 0..4 {
        let labelled = labeller.label(&scan, pose(&grazing)).unwrap();
        assert_eq!((labelled.counters.found_panes, labelled.panes.len()), (0, 1));
        assert_eq!(labelled.panes[0].misses, 0, "beams that graze it prove nothing");
        let behind = labelled.classes.iter().zip(&truth).filter(|(_, t)| t.class != PointClass::Inside);
        let in_place = behind.clone().filter(|((class, _), _)| *class == PointClass::Inside).count();
        assert!(20 * in_place <= behind.count(), "{in_place} stay inside");
    }
}

#[test]
fn truth_a_room_is_as_deep_as_all_that_is_seen_in_it() {
    if skipped() {
        return;
    }
    // A pane across the room behind the sensor: what lies beyond it meets that pane first, and is mirrored in the other all the same.
    let room = GlassRoom { yaw: 0.0, ..GlassRoom::default() };
    let (scan, truth) = room.scan();
    let mut labeller = Labeller::open(&Config::default(), &scan, None, false).unwrap();
    let pane = labeller.label(&scan, pose(&room)).unwrap().panes[0];
    let across =
        Pane { normal: Vec4::new(-1.0, 0.0, 0.0, 1.5), level: Vec4::new(0.0, 1.0, 0.0, 30.0), id: 9, ..pane };
    let across = Pane { extent_m: Vec4::new(-5.0, 5.0, -5.0, 5.0), hits: 5, ..across }.moved(pose(&room));
    labeller.load(set(vec![pane.moved(pose(&room)), across])).unwrap();
    let labelled = labeller.label(&scan, pose(&room)).unwrap();
    assert_eq!(labelled.panes.len(), 2);
    let of_reflections = |wanted: PointClass| {
        let pairs = truth.iter().zip(&labelled.classes);
        pairs.filter(|(truth, (class, _))| truth.class == PointClass::Reflection && *class == wanted).count()
    };
    let (real, mirrored) = (of_reflections(PointClass::Outside), of_reflections(PointClass::Reflection));
    assert!(mirrored > 500 && 50 * real < mirrored, "{real} outside, {mirrored} mirrored");
}
