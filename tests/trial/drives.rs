//! Whole trials in worlds where it is known what must happen.

use limpid::Config;
use limpid::offline::trial::{Outcome, Terms};

use super::{config, driven, hall, world};
use crate::sim::a_box;

/// What is left to the goal counts as driven, and the robot sets off at an angle to no way: little may be added.
const STRAIGHT_RATIO: f64 = 1.05;

#[test]
fn in_an_empty_hall_the_robot_arrives_straight() {
    let record = driven(&world(&hall(), [5.0, 1.0]), config(), Terms::default());
    assert_eq!(record.outcome, Outcome::Arrived, "{}", record.line());
    assert!((record.ideal_m - 26_f64.sqrt()).abs() < 0.03, "{}", record.ideal_m);
    let ratio = record.ratio().unwrap();
    assert!((0.999..STRAIGHT_RATIO).contains(&ratio), "{ratio}");
    assert_eq!(record.stops, 0);
    // At 0.5 m/s with a second of speeding up.
    assert!((9.0..14.0).contains(&record.time_s), "{}", record.time_s);
    let recall = record.map.obstacle_recall().unwrap();
    assert!(recall > 0.3, "the map saw the walls: {recall}");
    assert!(record.pictures.len() >= 9, "{}", record.pictures.len());
}

#[test]
fn through_a_door_and_twice_the_same_to_the_bit() {
    let mut scene = hall();
    scene.boxes = vec![a_box([3.0, -0.85, 1.0], [0.2, 2.3, 2.0]), a_box([3.0, 1.75, 1.0], [0.2, 0.5, 2.0])];
    let world = world(&scene, [5.0, 0.0]);
    let record = driven(&world, config(), Terms::default());
    assert_eq!(record.outcome, Outcome::Arrived, "{}", record.line());
    let ratio = record.ratio().unwrap();
    assert!((0.999..1.15).contains(&ratio), "{ratio}");
    // The door reaches from y = 0.3 to 1.5: the robot's centre keeps its radius from both sides.
    let at_door = record.steps.iter().filter(|step| (2.9..3.1).contains(&step.pose[0]));
    let across: Vec<f64> = at_door.map(|step| step.pose[1]).collect();
    assert!(!across.is_empty() && across.iter().all(|y| (0.48..1.32).contains(y)), "{across:?}");
    let again = driven(&world, config(), Terms::default());
    assert_eq!(again.steps, record.steps);
    assert_eq!((again.map, again.pictures), (record.map, record.pictures));
}

#[test]
fn a_map_that_sees_nothing_lets_the_robot_run_into_a_box() {
    let mut scene = hall();
    scene.boxes = vec![a_box([2.0, 0.0, 0.4], [0.4, 1.0, 0.8])];
    let high = Config { height_min_m: 1.8, height_max_m: 1.9, ..config() };
    let record = driven(&world(&scene, [5.0, 0.0]), high, Terms::default());
    assert_eq!(record.outcome, Outcome::Collision { with: "boxes[0]".into() });
    let end = record.steps.last().unwrap().pose;
    // The footprint's front is at the face of the box, x = 1.8, to the way of a fifth of a step.
    assert!((end[0] + 0.18 - 1.8).abs() < 0.06, "{end:?}");
}

#[test]
fn with_a_map_that_takes_the_floor_for_an_obstacle_the_robot_does_not_arrive() {
    let low = Config { ground_z_m: -0.3, ..config() };
    let record = driven(&world(&hall(), [5.0, 0.0]), low, Terms::default());
    assert!(matches!(record.outcome, Outcome::Frozen | Outcome::Timeout), "{}", record.line());
    assert_eq!(record.success(), Some(false));
    assert!(record.recoveries >= 3, "{}", record.recoveries);
    let acts: Vec<&str> = record.events.iter().map(|event| event.what.as_str()).take(3).collect();
    assert_eq!(acts, ["clear", "spin", "wait"]);
}

#[test]
fn a_camera_that_dies_stops_the_robot() {
    let terms = Terms { dies_at_s: Some(4.0), ..Terms::default() };
    let record = driven(&world(&hall(), [5.0, 0.0]), config(), terms);
    let Outcome::Halted { way_m, after_s } = record.outcome else { panic!("{}", record.line()) };
    // Stale after 0.5 s, then 0.5 s of braking from 0.5 m/s at 1 m/s².
    assert!((0.9..1.4).contains(&after_s), "{after_s}");
    assert!((0.2..0.5).contains(&way_m), "{way_m}");
    assert_eq!(record.success(), Some(true));
}

#[test]
fn time_runs_out() {
    let terms = Terms { time_share: 0.5, ..Terms::default() };
    let record = driven(&world(&hall(), [5.0, 0.0]), config(), terms);
    assert_eq!(record.outcome, Outcome::Timeout);
    assert!((record.time_s - 5.0).abs() < 0.3, "{}", record.time_s);
    assert_eq!((record.success(), record.ratio()), (Some(false), None));
}
