//! A way through the free space of a scene.

use glam::DVec2;

use super::Random;
use crate::sim::footprint::{Footprint, footprints};
use crate::sim::scene::Scene;
use crate::sim::trajectory::poses;
use crate::sim::walls::is_inside;

/// Kept from everything, metres; more than the scene's own clearance, for the camera lies before the robot's centre.
const GAP_M: f64 = 0.5;
const TRIALS: u32 = 400;

/// Lays waypoints until the way takes as many frames as the scene asks for; `false` where none are found.
pub(super) fn lay(scene: &mut Scene, random: &mut Random) -> bool {
    let things: Vec<Footprint> =
        footprints(scene).into_iter().filter(|thing| thing.span_m[0] < 1.5 && !thing.passable).collect();
    let free = |scene: &Scene, at: DVec2| {
        is_inside(scene, at.x, at.y) && things.iter().all(|thing| thing.shape.distance_m(at) > GAP_M)
    };
    let mut way: Vec<DVec2> = Vec::new();
    for _ in 0..TRIALS {
        let room = &scene.rooms[random.count(0, u32::try_from(scene.rooms.len() - 1).unwrap_or(0)) as usize];
        let at = DVec2::new(
            random.within(room.min_m[0], room.max_m[0]),
            random.within(room.min_m[1], room.max_m[1]),
        );
        let straight = |from: DVec2| {
            let length = from.distance(at);
            let mut gone = 0.0;
            while gone < length {
                if !free(scene, from.lerp(at, gone / length)) {
                    return false;
                }
                gone += 0.05;
            }
            length > 1.0
        };
        if free(scene, at) && way.last().is_none_or(|&last| straight(last)) {
            way.push(at);
            scene.trajectory.waypoints_m = way.iter().map(|p| p.to_array()).collect();
            if way.len() > 1 && poses(scene).len() >= scene.trajectory.frames as usize {
                return true;
            }
        }
    }
    false
}
