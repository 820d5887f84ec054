//! Scores of labels against those of a recording: the figures of the 3DRef frames.
//!
//! Labels of a recording are 3DRef's: 0 none, 1 normal, 2 glass, 3 mirror, 4 other reflective, 5 reflection, 6 obstacle
//! behind glass. Points of label 0 are left out; those of 3 and 4 count as wrong only if called reflection or outside.

use std::collections::HashMap;

use glam::{DVec3, IVec3};
use serde::Serialize;

use crate::map::Pane;
use crate::map::glass::{GlassCounters, LabelledScan, PointClass};
use crate::sensor::{Point, Scan};

/// Label of real points before any glass.
const NORMAL: u32 = 1;
/// Mirrors and other reflective surfaces: real, and not asked for.
const REFLECTIVE: [u32; 2] = [3, 4];
/// Label of points that are reflections.
const VIRTUAL: u32 = 5;
/// The class that each label asks for.
const WANTED: [(u32, PointClass); 4] = [
    (NORMAL, PointClass::Inside),
    (2, PointClass::Glass),
    (VIRTUAL, PointClass::Reflection),
    (6, PointClass::Outside),
];
/// A mirrored point this near to a normal one has come back to where it belongs, metres.
const NEAR_M: f64 = 0.2;
/// The baseline drops what lies farther behind a plane, metres.
const BEHIND_M: f64 = 0.1;

/// Counts of one class.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Tally {
    wanted: u64,
    called: u64,
    both: u64,
}

/// Scores of one class, as shares.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct ClassScore {
    /// Of what was called so, what is so.
    pub precision: f64,
    /// Of what is so, what was called so.
    pub recall: f64,
    /// Of what is or was called so, what is both.
    pub iou: f64,
}

/// Scores by class.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct ClassScores {
    /// Real, before the panes.
    pub inside: ClassScore,
    /// On them.
    pub glass: ClassScore,
    /// In them.
    pub reflection: ClassScore,
    /// Real, behind them.
    pub outside: ClassScore,
}

/// Scores of a recording, as shares of all its points.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct GlassScores {
    /// By class.
    pub classes: ClassScores,
    /// Of the reflections those that stay where they are in the cleaned cloud.
    pub reflections_left: f64,
    /// Of the normal points those that the cleaned cloud does not have in place.
    pub normal_lost: f64,
    /// Of the mirrored points those within 0.2 m of a normal point of their scan.
    pub mirrored_within_0_2_m: f64,
}

/// Sums over scans.
#[derive(Debug, Clone, Default)]
pub struct GlassTally {
    classes: [Tally; 4],
    reflections: u64,
    reflections_left: u64,
    normal: u64,
    normal_lost: u64,
    mirrored: u64,
    mirrored_near: u64,
}

/// Whether the cleaned cloud has a point of this class where it was measured.
fn stays(class: PointClass) -> bool {
    matches!(class, PointClass::Inside | PointClass::Glass | PointClass::Outside)
}

impl GlassTally {
    /// Counts a scan in; points that `labelled` lacks count as not labelled.
    pub fn add(&mut self, scan: &Scan, labelled: &LabelledScan) {
        let classes = labelled.classes.iter().copied().chain(std::iter::repeat((PointClass::default(), 0)));
        for (point, (class, _)) in scan.points.iter().zip(classes.clone()) {
            self.count(point.label, class);
        }
        let place = |point: &Point| DVec3::from(point.position_m().map(f64::from));
        let normal = scan.points.iter().filter(|point| point.label == NORMAL).map(place);
        let near = Near::new(normal);
        for (point, (class, pane_id)) in scan.points.iter().zip(classes) {
            let pane = labelled.panes.iter().find(|pane| pane.id == pane_id);
            if let (PointClass::Reflection, Some(pane)) = (class, pane) {
                self.mirrored += 1;
                self.mirrored_near += u64::from(near.has(pane.mirrored_m(place(point))));
            }
        }
    }

    /// Takes the counts of other scans in.
    pub fn join(&mut self, other: &Self) {
        for (own, other) in self.classes.iter_mut().zip(&other.classes) {
            own.wanted += other.wanted;
            own.called += other.called;
            own.both += other.both;
        }
        for (own, other) in [
            (&mut self.reflections, other.reflections),
            (&mut self.reflections_left, other.reflections_left),
            (&mut self.normal, other.normal),
            (&mut self.normal_lost, other.normal_lost),
            (&mut self.mirrored, other.mirrored),
            (&mut self.mirrored_near, other.mirrored_near),
        ] {
            *own += other;
        }
    }

    fn count(&mut self, label: u32, class: PointClass) {
        if label == 0 || label > 6 {
            return;
        }
        for (tally, (wanted, of)) in self.classes.iter_mut().zip(WANTED) {
            let is = label == wanted;
            let harmless =
                REFLECTIVE.contains(&label) && matches!(of, PointClass::Inside | PointClass::Glass);
            let called = class == of && !harmless;
            tally.wanted += u64::from(is);
            tally.called += u64::from(called);
            tally.both += u64::from(is && called);
        }
        self.reflections += u64::from(label == VIRTUAL);
        self.reflections_left += u64::from(label == VIRTUAL && stays(class));
        self.normal += u64::from(label == NORMAL);
        self.normal_lost += u64::from(label == NORMAL && !stays(class));
    }

    /// The shares; 0 of nothing is 0.
    pub fn scores(&self) -> GlassScores {
        let [inside, glass, reflection, outside] = self.classes.map(|tally| ClassScore {
            precision: share(tally.both, tally.called),
            recall: share(tally.both, tally.wanted),
            iou: share(tally.both, tally.wanted + tally.called - tally.both),
        });
        GlassScores {
            classes: ClassScores { inside, glass, reflection, outside },
            reflections_left: share(self.reflections_left, self.reflections),
            normal_lost: share(self.normal_lost, self.normal),
            mirrored_within_0_2_m: share(self.mirrored_near, self.mirrored),
        }
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts of points are far below 2^53")]
fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 { 0.0 } else { part as f64 / whole as f64 }
}

/// The baseline: whatever lies more than 0.1 m behind the plane of a pane, however far from the pane itself, is called a
/// reflection and so dropped; all else stays.
pub fn drop_behind_planes(scan: &Scan, panes: &[Pane]) -> LabelledScan {
    let class = |point: &Point| {
        let place_m = DVec3::from(point.position_m().map(f64::from));
        let over_m = |pane: &Pane| pane.unit_normal().as_dvec3().dot(place_m) - f64::from(pane.normal.w);
        let behind = panes.iter().find(|pane| over_m(pane) > BEHIND_M);
        behind.map_or((PointClass::Inside, 0), |pane| (PointClass::Reflection, pane.id))
    };
    LabelledScan {
        classes: scan.points.iter().map(class).collect(),
        panes: panes.to_vec(),
        counters: GlassCounters::default(),
        pass_ms: Vec::new(),
    }
}

/// Points by cubes of [`NEAR_M`].
struct Near {
    cubes: HashMap<IVec3, Vec<DVec3>>,
}

impl Near {
    fn new(points: impl Iterator<Item = DVec3>) -> Self {
        let mut cubes: HashMap<IVec3, Vec<DVec3>> = HashMap::new();
        for point in points {
            cubes.entry(Self::cube(point)).or_default().push(point);
        }
        Self { cubes }
    }

    fn cube(point: DVec3) -> IVec3 {
        (point / NEAR_M).floor().as_ivec3()
    }

    fn has(&self, point: DVec3) -> bool {
        let middle = Self::cube(point);
        let around = (0..27).map(|k| middle + IVec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
        around
            .filter_map(|cube| self.cubes.get(&cube))
            .any(|points| points.iter().any(|other| other.distance(point) < NEAR_M))
    }
}
