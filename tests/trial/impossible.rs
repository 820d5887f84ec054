//! Tasks that cannot be done say so, and count for nothing.

use glam::DVec2;
use limpid::Error;
use limpid::offline::trial::{Limits, Outcome, Pose, Report, Terms, World};
use limpid::sim::Scene;
use limpid::sim::scene::Room;
use limpid::sim::walker::Walker;

use super::{config, driven, hall, world};
use crate::sim::a_box;

#[track_caller]
fn refused(scene: &Scene, goal: [f64; 2], part: &str) {
    let world = world(scene, goal);
    let said = world.impossible.clone().unwrap_or_default();
    assert!(said.contains(part), "{said:?} has no {part:?}");
    let record = driven(&world, config(), Terms::default());
    assert_eq!((record.success(), record.ratio(), record.steps.len()), (None, None, 0));
    assert!(matches!(&record.outcome, Outcome::Impossible { reason } if *reason == said));
    let report = Report { records: vec![record] };
    assert!(report.groups().is_empty(), "it counts for nothing");
    assert!(report.text().contains(part), "{}", report.text());
}

#[test]
fn goals_that_cannot_be_reached() {
    let mut scene = hall();
    scene.boxes = vec![a_box([3.0, 1.0, 0.5], [0.5, 0.5, 1.0])];
    refused(&scene, [3.0, 1.0], "the goal lies in or at an obstacle, boxes[0]");
    // Nearer to a wall than the robot's radius.
    refused(&scene, [5.0, 1.9], "the goal lies in or at an obstacle, rooms[0]");
    refused(&scene, [20.0, 0.0], "the goal lies outside of the world");
    refused(&scene, [f64::NAN, 0.0], "the goal is not a place");
    scene.rooms.push(Room { min_m: [8.0, -1.0], max_m: [10.0, 1.0], walls: "walls".into() });
    refused(&scene, [9.0, 0.0], "cannot be reached");
    // A gap that is too narrow for the robot: 0.34 m for a diameter of 0.36 m.
    scene.boxes =
        vec![a_box([3.0, -1.085, 1.0], [0.2, 1.83, 2.0]), a_box([3.0, 1.085, 1.0], [0.2, 1.83, 2.0])];
    refused(&scene, [5.0, 0.0], "cannot be reached");
}

#[test]
fn a_world_without_floor_has_no_task() {
    let mut scene = hall();
    scene.rooms.clear();
    refused(&scene, [5.0, 0.0], "no floor");
}

#[test]
fn people_are_not_driven_among() {
    let mut scene = hall();
    let waypoints_m = vec![[3.0, 1.0]];
    let (speed_m_s, ahead_s, radius_m, height_m, material) = (1.0, 0.0, 0.2, 1.7, "walls".into());
    scene.walkers = vec![Walker { waypoints_m, speed_m_s, ahead_s, radius_m, height_m, material }];
    refused(&scene, [5.0, 0.0], "people walk");
}

#[test]
fn starts_in_obstacles() {
    let mut scene = hall();
    scene.boxes = vec![a_box([0.1, 0.0, 0.5], [0.5, 0.5, 1.0])];
    refused(&scene, [5.0, 0.0], "the start lies in or at an obstacle, boxes[0]");
}

#[test]
fn what_cannot_be_a_scene_is_an_error() {
    let mut scene = hall();
    scene.camera.width = 100;
    let start = Pose { at: DVec2::ZERO, yaw: 0.0 };
    let world = World::new(&scene, start, DVec2::new(5.0, 0.0), &Limits::default(), &config());
    assert!(matches!(world.map(|_| ()), Err(Error::Config { key, .. }) if key == "camera.width"));
}
