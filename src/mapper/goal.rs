//! Where the robot's goal lies.

use glam::{DVec2, DVec3};

use crate::config::Config;
use crate::sensor::SensorPose;

/// The goal's direction; that of the robot's x axis without a goal; `None` within a cell of the goal.
pub(super) fn towards_goal(
    config: &Config,
    goal_m: Option<DVec2>,
    pose: SensorPose,
    resolution_m: f64,
) -> Option<DVec2> {
    let stated = match config.goal_m[..] {
        [x, y] => Some(DVec2::new(x, y)),
        _ => None,
    };
    let way = match goal_m.or(stated) {
        Some(goal_m) => {
            let way_m = goal_m - pose.map_from_base.translation_m.truncate();
            (way_m.length() > resolution_m).then_some(way_m)?
        }
        None => (pose.map_from_base.rotation * DVec3::X).truncate(),
    };
    way.try_normalize()
}
