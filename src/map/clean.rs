//! The cleaned cloud: what a SLAM system takes (spec 3 §7).

use glam::DVec3;

use crate::map::glass::{LabelledScan, PointClass};
use crate::sensor::{Point, Scan};

/// A point of the cleaned cloud.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CleanPoint<'a> {
    /// The measurement.
    pub measured: &'a Point,
    /// Where it belongs, metres, in the lidar's frame: mirrored back where it is a reflection.
    pub place_m: DVec3,
    /// Inside, glass, outside, or a reflection that was mirrored back.
    pub class: PointClass,
    /// Its pane; 0: none.
    pub pane_id: u32,
}

/// Inside, glass and outside points in place and reflections mirrored back, in the scan's order; what is not labelled is
/// left out.
pub fn cleaned<'a>(scan: &'a Scan, labelled: &'a LabelledScan) -> impl Iterator<Item = CleanPoint<'a>> {
    scan.points.iter().zip(&labelled.classes).filter_map(|(measured, &(class, pane_id))| {
        let place_m = DVec3::from(measured.position_m().map(f64::from));
        let place_m = match class {
            PointClass::Unlabelled => return None,
            PointClass::Reflection => {
                labelled.panes.iter().find(|pane| pane.id == pane_id)?.mirrored_m(place_m)
            }
            _ => place_m,
        };
        Some(CleanPoint { measured, place_m, class, pane_id })
    })
}
