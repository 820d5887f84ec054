//! Scores, by hand.

use limpid::map::Pane;
use limpid::map::glass::{LabelledScan, PointClass};
use limpid::offline::eval::glass_metrics::{ClassScore, GlassTally};
use limpid::sensor::{Columns, Dropped, Point, ReturnType, Scan, Strength};

use PointClass::{Glass, Inside, Outside, Reflection, Unlabelled};

fn scan(points: &[(f32, u32)]) -> Scan {
    let point = |&(x_m, label): &(f32, u32)| Point {
        x_m,
        y_m: 0.0,
        z_m: 0.0,
        intensity: 1.0,
        time_s: 0.0,
        ring: 0,
        column: 0,
        return_type: ReturnType::Single,
        strength: Strength::Unknown,
        reserved: 0,
        label,
    };
    Scan {
        index: 0,
        stamp_ns: 0,
        frame_id: String::new(),
        points: points.iter().map(point).collect(),
        columns: Columns { label: true, ..Columns::default() },
        dropped: Dropped::default(),
    }
}

/// A mirror at x = 5.
fn labelled(classes: &[PointClass]) -> LabelledScan {
    let pane = Pane {
        normal: glam::Vec4::new(1.0, 0.0, 0.0, 5.0),
        level: glam::Vec4::new(0.0, 1.0, 0.0, 0.0),
        extent_m: glam::Vec4::new(-1.0, 1.0, -1.0, 1.0),
        id: 3,
        ..Pane::default()
    };
    LabelledScan {
        classes: classes.iter().map(|&class| (class, 3)).collect(),
        panes: vec![pane],
        counters: Default::default(),
        pass_ms: vec![],
    }
}

fn score(precision: f64, recall: f64, iou: f64) -> ClassScore {
    ClassScore { precision, recall, iou }
}

#[test]
fn a_small_cloud_by_hand() {
    let scan = scan(&[
        (1.0, 1), // inside
        (2.0, 1), // called a reflection: lost
        (3.0, 1), // not labelled: lost
        (4.9, 2), // glass
        (5.0, 2), // called inside
        (9.1, 5), // a reflection; comes back to 0.9, 0.1 from a normal point
        (9.9, 5), // called outside: left; and one at 0.1 would be near nothing
        (8.5, 5), // not labelled: neither found nor left
        (20.0, 6),
        (4.0, 3), // a mirror called inside: no error
        (4.0, 4), // another reflective surface called a reflection: an error; comes back to 6
        (4.0, 0), // no label: left out
    ]);
    let classes = [
        Inside, Reflection, Unlabelled, Glass, Inside, Reflection, Outside, Unlabelled, Outside, Inside,
        Reflection, Reflection,
    ];
    let mut tally = GlassTally::default();
    tally.add(&scan, &labelled(&classes));
    let scores = tally.scores();
    assert_eq!(scores.classes.inside, score(0.5, 1.0 / 3.0, 0.25));
    assert_eq!(scores.classes.glass, score(1.0, 0.5, 0.5));
    assert_eq!(scores.classes.reflection, score(1.0 / 3.0, 1.0 / 3.0, 0.2));
    assert_eq!(scores.classes.outside, score(0.5, 1.0, 0.5));
    assert_eq!(scores.reflections_left, 1.0 / 3.0);
    assert_eq!(scores.normal_lost, 2.0 / 3.0);
    // Mirrored: 2.0 -> 8.0 (no), 9.1 -> 0.9 (yes), 4.0 -> 6.0 twice (no).
    assert_eq!(scores.mirrored_within_0_2_m, 0.25);
}

#[test]
fn points_that_the_labels_lack_are_misses() {
    let mut tally = GlassTally::default();
    tally.add(&scan(&[(1.0, 1), (2.0, 1)]), &labelled(&[Inside]));
    let scores = tally.scores();
    assert_eq!(scores.classes.inside, score(1.0, 0.5, 0.5));
    assert_eq!(scores.normal_lost, 0.5);
}

#[test]
fn nothing_scores_nothing() {
    let scores = GlassTally::default().scores();
    assert_eq!(scores.classes.inside, ClassScore::default());
    assert_eq!((scores.reflections_left, scores.normal_lost), (0.0, 0.0));
}
