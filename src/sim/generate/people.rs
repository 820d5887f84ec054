//! People who walk past before the camera.

use glam::DVec2;

use super::Random;
use crate::sim::footprint::footprints;
use crate::sim::material::Material;
use crate::sim::scene::Scene;
use crate::sim::trajectory::poses;
use crate::sim::walker::Walker;
use crate::sim::walls::is_inside;

/// Kept from things and from the robot's way, by a person's axis, metres.
const GAP_M: f64 = 0.35;
const GAP_TO_ROBOT_M: f64 = 0.7;
/// Longest way to either side of where the person crosses the camera's axis, metres.
const REACH_M: f64 = 2.5;
const STEP_M: f64 = 0.05;
const TRIALS: u32 = 400;

/// The material of their clothes.
const CLOTHES: &str = "clothes";

/// Adds people who cross the view to and fro, drawn for the scene's seed; says how many found room.
pub fn add_walkers(scene: &mut Scene, count: u32) -> u32 {
    let mut random = Random::new(scene.seed ^ 0x7065_6f70);
    let clothes = Material { albedo: [0.3, 0.25, 0.35], albedo_ir: 0.45, ..Material::default() };
    let mut added = 0;
    for _ in 0..TRIALS {
        if added == count {
            break;
        }
        let Some(waypoints_m) = crossing(scene, &mut random) else { continue };
        scene.materials.entry(CLOTHES.into()).or_insert_with(|| clothes.clone());
        scene.walkers.push(Walker {
            waypoints_m,
            speed_m_s: random.within(0.6, 1.6),
            ahead_s: random.within(0.0, 5.0),
            radius_m: random.within(0.16, 0.26),
            height_m: random.within(1.3, 1.9),
            material: CLOTHES.into(),
        });
        added += 1;
    }
    added
}

/// The ends of a free way across the camera's axis at some frame.
fn crossing(scene: &Scene, random: &mut Random) -> Option<Vec<[f64; 2]>> {
    let things: Vec<_> = footprints(scene).into_iter().filter(|thing| thing.span_m[0] < 2.0).collect();
    let robot: Vec<_> = poses(scene).iter().map(|pose| pose.map_from_base).collect();
    let free = |at: DVec2| {
        is_inside(scene, at.x, at.y)
            && things.iter().all(|thing| thing.shape.distance_m(at) > GAP_M)
            && robot.iter().all(|pose| pose.translation_m.truncate().distance(at) > GAP_TO_ROBOT_M)
    };
    let frame = random.count(0, u32::try_from(robot.len()).ok()?.checked_sub(1)?);
    let pose = robot.get(frame as usize)?;
    let ahead = pose.rotation_matrix().x_axis.truncate();
    let centre = pose.translation_m.truncate() + ahead * random.within(1.2, 4.0);
    let aside = DVec2::from_angle(random.within(-0.6, 0.6)).rotate(ahead.perp());
    let reach = |side: f64| {
        let mut gone_m = 0.0;
        while gone_m < REACH_M && free(centre + aside * side * (gone_m + STEP_M)) {
            gone_m += STEP_M;
        }
        centre + aside * side * gone_m
    };
    let ends = [reach(-1.0), reach(1.0)];
    (free(centre) && ends[0].distance(ends[1]) > 1.5).then(|| ends.map(|end| end.to_array()).to_vec())
}
