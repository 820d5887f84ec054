//! Panes in the map.

use glam::DVec3;

use crate::base::Rigid;
use crate::map::Pane;

/// Panes in the map's axes, with coordinates from a place in the map: coordinates of a pane are f32, which has steps of half a
/// metre where a map counts from far away (UTM).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PaneSet {
    /// The place in the map from which coordinates count, metres.
    pub origin_m: DVec3,
    /// The panes.
    pub panes: Vec<Pane>,
}

impl PaneSet {
    /// The panes of a scan, given in the lidar's frame, with the lidar at `map_from_lidar`.
    pub fn of_scan(panes: &[Pane], map_from_lidar: Rigid) -> Self {
        let origin_m = Self::origin_near(map_from_lidar);
        let local_from_lidar = map_from_lidar.from_origin(origin_m);
        Self { origin_m, panes: panes.iter().map(|pane| pane.moved(local_from_lidar)).collect() }
    }

    /// Whole metres near the lidar.
    pub fn origin_near(map_from_lidar: Rigid) -> DVec3 {
        map_from_lidar.translation_m.round()
    }

    /// The panes with coordinates from another place in the map.
    pub fn from_origin(&self, origin_m: DVec3) -> Vec<Pane> {
        let moved = Rigid { translation_m: self.origin_m - origin_m, ..Rigid::IDENTITY };
        self.panes.iter().map(|pane| pane.moved(moved)).collect()
    }
}
