//! Real recordings, where they are.

use limpid::base::Rigid;
use limpid::input::points;
use limpid::input::points::Options;
use limpid::offline::eval::glass_metrics::GlassTally;
use limpid::offline::labeller::Labeller;
use limpid::sensor::BeamGrid;
use limpid::sensor::Scan;

use super::{alone, label};
use crate::support::data_dir;
use crate::support::gpu::skipped;

fn scans(name: &str) -> Option<Vec<Scan>> {
    let path = data_dir(name)?;
    let mut reader = points::open(&path, &Options::default()).unwrap();
    let mut list = Vec::new();
    while let Some(scan) = reader.next_scan().unwrap() {
        list.push(scan);
    }
    Some(list)
}

/// The frame and itself turned about the vertical by an angle that is no multiple of a column.
fn turned(scan: &Scan, angle_rad: f32, mirrored: bool) -> Scan {
    let mut scan = scan.clone();
    let (sin, cos) = angle_rad.sin_cos();
    for point in &mut scan.points {
        let y_m = if mirrored { -point.y_m } else { point.y_m };
        (point.x_m, point.y_m) = (point.x_m * cos - y_m * sin, point.x_m * sin + y_m * cos);
    }
    scan
}

#[test]
fn the_labelled_room_reaches_the_goals_of_single_frames_however_it_is_turned() {
    let Some(scans) = scans("lidar/3dref-hesai-qt64-dual") else { return };
    if skipped() {
        return;
    }
    for (angle_rad, mirrored) in [(0.0, false), (0.65, false), (-2.0, true)] {
        let mut tally = GlassTally::default();
        let mut labeller: Option<Labeller> = None;
        for scan in scans.iter().step_by(2).map(|scan| turned(scan, angle_rad, mirrored)) {
            let labeller =
                labeller.get_or_insert_with(|| Labeller::open(&alone(), &scan, None, false).unwrap());
            let labelled = labeller.label(&scan, Rigid::IDENTITY).unwrap();
            assert_eq!(labelled.panes.len(), 1);
            tally.add(&scan, &labelled);
        }
        let scores = tally.scores();
        let what = format!("turned by {angle_rad}, mirrored {mirrored}: {scores:?}");
        assert!(scores.classes.inside.iou > 0.96, "{what}");
        assert!(scores.classes.glass.iou > 0.66, "{what}");
        assert!(scores.classes.reflection.iou > 0.65, "{what}");
        assert!(scores.classes.outside.iou > 0.45, "{what}");
        assert!(scores.reflections_left < 0.08 && scores.normal_lost < 0.005, "{what}");
    }
}

#[test]
fn a_recording_without_rings_in_use_gives_a_grid_of_its_beams() {
    let Some(scans) = scans("lidar/3dref.mcap") else { return };
    let grid = BeamGrid::of_scan(&scans[0]).unwrap();
    assert_eq!((grid.rows, grid.columns, grid.by_ring), (64, 600, true));
}

#[test]
fn a_street_without_panes_has_none() {
    let Some(scans) = scans("lidar/veloview-hdl32e-vlp16-strongest/monterey-first-100-packets.pcap") else {
        return;
    };
    if skipped() {
        return;
    }
    let largest = scans.iter().max_by_key(|scan| scan.points.len()).unwrap();
    let labelled = label(&alone(), largest);
    assert_eq!(labelled.panes.len(), 0, "{:?}", labelled.counters);
}
