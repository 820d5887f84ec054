//! Labels of whole scans against a twin in plain loops.

use glam::DVec3;
use limpid::Config;
use limpid::base::Rigid;
use limpid::map::Pane;
use limpid::map::PaneSet;
use limpid::map::glass::PointClass;
use limpid::offline::labeller::Labeller;
use limpid::sensor::BeamGrid;
use limpid::sensor::{Point, ReturnType, Scan};

use crate::reference::glass::{Beam, Organized, Rules, labels, organize};
use crate::support::glass_room::GlassRoom;
use crate::support::gpu::skipped;

fn alone() -> Config {
    Config { glass_memory: false, ..Config::default() }
}

fn by_twin(scan: &Scan, grid: &BeamGrid, pane: &Pane) -> Vec<PointClass> {
    let config = alone();
    let place = |point: &Point| DVec3::from(point.position_m().map(f64::from));
    let places_m: Vec<DVec3> = scan.points.iter().map(place).collect();
    let intensities: Vec<f64> = scan.points.iter().map(|point| f64::from(point.intensity)).collect();
    let beam = |point: &Point| -> Beam {
        let row = grid.ring_rows[usize::from(point.ring)] as usize;
        (point.position_m(), row, usize::from(point.return_type == ReturnType::Last))
    };
    let beams: Vec<Beam> = scan.points.iter().map(beam).collect();
    let (columns, rows) = (grid.columns as usize, grid.rows as usize);
    let cells = organize(&beams, columns);
    let row_of = |p: DVec3| {
        let share = p.z.atan2(p.x.hypot(p.y)) / std::f64::consts::PI + 0.5;
        let row = grid.elevation_rows[(share * 2048.0).clamp(0.0, 2047.0) as usize];
        (row < grid.rows).then_some(row as usize)
    };
    let [half_rows, half_columns] = grid.cells_within(config.glass_slack_deg).map(i64::from);
    let rules = Rules {
        plane_tolerance_m: config.glass_plane_tolerance_m,
        match_m: config.glass_match_m,
        match_per_m: config.glass_match_per_m,
        lobe_cos: config.glass_lobe_deg.to_radians().cos(),
        half_rows,
        half_columns,
        gap_m: config.glass_return_gap_m,
    };
    let organized = Organized {
        places_m: &places_m,
        intensities: &intensities,
        beams: &beams,
        cells: &cells,
        columns,
        rows,
        row_of: &row_of,
    };
    labels(&organized, pane, &rules)
}

/// Points that the two call differently, and points that are not called inside.
fn differing(got: &[(PointClass, u32)], want: &[PointClass]) -> (usize, usize) {
    assert_eq!(got.len(), want.len());
    let differ = got.iter().zip(want).filter(|((got, _), want)| got != *want).count();
    (differ, want.iter().filter(|class| **class != PointClass::Inside).count())
}

#[test]
fn twin_of_labels_on_rooms_at_all_sizes() {
    if skipped() {
        return;
    }
    for (yaw, sensor_m) in [(0.0, DVec3::new(0.3, 0.2, 0.0)), (1.1, DVec3::new(1.4, -0.9, 0.1))] {
        let room = GlassRoom { yaw, sensor_m, ..GlassRoom::default() };
        let (scan, _) = room.scan();
        let mut labeller = Labeller::open(&alone(), &scan, None, false).unwrap();
        let labelled = labeller.label(&scan, Rigid::IDENTITY).unwrap();
        let pane = labelled.panes[0];
        let grid = labeller.grid().clone();
        let want = by_twin(&scan, &grid, &pane);
        let (differ, met) = differing(&labelled.classes, &want);
        // Only what lies at a threshold may differ: angles and ranges are rounded otherwise.
        assert!(met > 1000 && 200 * differ <= met, "yaw {yaw}: {differ} of {met}");
        for class in PointClass::ALL {
            assert!(class == PointClass::Unlabelled || want.contains(&class), "{class:?} does not occur");
        }
        // The control: of a pane 0.4 m farther the twin says something else.
        let moved = Pane { normal: pane.normal + glam::Vec4::W * 0.4, ..pane };
        let (differ, _) = differing(&labelled.classes, &by_twin(&scan, &grid, &moved));
        assert!(5 * differ > met, "{differ} of {met}");
        for count in [1, 63, 64, 65, 257] {
            let mut few = scan.clone();
            // From the middle of the pane on.
            few.points.drain(..scan.points.len() / 2);
            few.points.truncate(count);
            labeller.load(PaneSet { panes: vec![pane], ..PaneSet::default() }).unwrap();
            let labelled = labeller.label(&few, Rigid::IDENTITY).unwrap();
            if labelled.panes.len() == 1 {
                let (differ, _) = differing(&labelled.classes, &by_twin(&few, &grid, &pane));
                assert!(100 * differ <= count, "{differ} of {count}");
            }
        }
    }
}
