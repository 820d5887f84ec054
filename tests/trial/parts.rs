//! Ways over prices, the robot's motion, runs of letters.

use glam::DVec2;
use limpid::map::{Grid, MapUpdate, State};
use limpid::offline::trial::record::runs;
use limpid::offline::trial::robot::{Robot, Speed, wrapped};
use limpid::offline::trial::route::{BLOCKED, FREE_PRICE, Prices, ahead, length_m, price_of};
use limpid::offline::trial::{Limits, Pose};

/// Cells of 0.1 m from the origin, of which some are blocked.
fn prices(width: u32, height: u32, is_blocked: impl Fn(u32, u32) -> bool) -> Prices {
    let grid = Grid { origin_x_m: 0.0, origin_y_m: 0.0, resolution_m: 0.1, width, height };
    let price = |x: u32, y: u32| if is_blocked(x, y) { BLOCKED } else { FREE_PRICE };
    let cells = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| price(x, y)).collect();
    Prices { grid, cells }
}

#[test]
fn on_a_free_floor_the_way_is_the_straight_line_at_any_angle() {
    let floor = prices(100, 100, |_, _| false);
    let from = DVec2::new(0.5, 0.5);
    for goal in [[9.5, 0.5], [9.5, 4.2], [7.3, 9.1], [1.0, 9.0]].map(DVec2::from_array) {
        let way = floor.way(from, goal).unwrap();
        assert!(length_m(&way) < 1.002 * from.distance(goal), "{way:?}");
        assert_eq!((way[0], *way.last().unwrap()), (from, goal));
    }
}

#[test]
fn around_a_wall_the_way_has_the_length_of_two_straight_lines() {
    // A wall at x = 5 from the bottom up to y = 6.
    let floor = prices(100, 100, |x, y| x == 50 && y < 60);
    let (from, goal) = (DVec2::new(2.05, 1.05), DVec2::new(8.05, 1.05));
    let corner = DVec2::new(5.05, 6.05);
    let shortest = from.distance(corner) + corner.distance(goal);
    let way = floor.way(from, goal).unwrap();
    assert!((shortest..shortest * 1.02).contains(&length_m(&way)), "{} {shortest}", length_m(&way));
    let closed = prices(100, 100, |x, _| x == 50);
    assert_eq!(closed.way(from, goal), None);
    assert_eq!(floor.way(from, DVec2::new(30.0, 0.0)), None, "outside");
}

#[test]
fn a_diagonal_gap_between_two_blocked_cells_is_no_way() {
    let floor = prices(10, 10, |x, y| x + y == 9);
    assert_eq!(floor.way(DVec2::splat(0.15), DVec2::splat(0.85)), None);
}

#[test]
fn a_blocked_goal_is_approached_within_half_a_metre() {
    let floor = prices(100, 100, |x, y| (50..56).contains(&x) && (50..56).contains(&y));
    let goal = DVec2::new(5.35, 5.35);
    let end = *floor.way(DVec2::splat(1.0), goal).unwrap().last().unwrap();
    assert!((0.05..=0.5).contains(&end.distance(goal)), "{end}");
    let wide = prices(100, 100, |x, y| (40..70).contains(&x) && (40..70).contains(&y));
    assert_eq!(wide.way(DVec2::splat(1.0), goal), None);
}

#[test]
fn prices_of_costs() {
    assert_eq!([0, 252, 253, 254, 255].map(price_of), [100, 300, BLOCKED, BLOCKED, 300]);
    assert!(price_of(100) > price_of(50));
}

#[test]
fn floor_around_the_window_is_unknown_and_keeps_the_cells_in_place() {
    let grid = Grid { origin_x_m: -1.0, origin_y_m: -1.0, resolution_m: 0.5, width: 4, height: 4 };
    let mut costmap = vec![0; 16];
    costmap[5] = 254;
    let (verdicts, classes, sensors) = (Vec::new(), Vec::new(), Vec::new());
    let map = MapUpdate { grid, costmap, verdicts, classes, towards_goal: None, state: State::Ok, sensors };
    let prices = Prices::around(&map, DVec2::ZERO, DVec2::new(6.0, 0.0));
    let at = |x: f64, y: f64| prices.at(DVec2::new(x, y));
    assert_eq!([at(-0.25, -0.25), at(0.25, 0.25), at(5.0, 0.2)], [BLOCKED, 100, 300]);
    assert_eq!(at(20.0, 0.0), BLOCKED, "outside of all");
    assert!(prices.way(DVec2::new(0.2, 0.2), DVec2::new(6.0, 0.0)).is_some());
}

#[test]
fn places_ahead_on_a_way() {
    let way = [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0]].map(DVec2::from_array);
    let at = |x: f64, y: f64, along: f64| ahead(&way, DVec2::new(x, y), along).unwrap();
    assert!(at(0.2, 0.3, 0.5).distance(DVec2::new(0.7, 0.0)) < 1e-12);
    assert!(at(0.5, 0.0, 1.0).distance(DVec2::new(1.0, 0.5)) < 1e-12);
    assert_eq!(at(1.2, 1.9, 5.0), way[2]);
    assert_eq!(ahead(&[], DVec2::ZERO, 1.0), None);
}

fn robot(drift: f64) -> Robot {
    Robot::new(Limits::default(), Pose::default(), drift, 3)
}

#[test]
fn the_robot_keeps_its_limits_and_moves_on_arcs() {
    let mut robot = robot(0.0);
    robot.drive(Speed { v: 9.0, omega: -9.0 }, 0.1);
    assert!((robot.speed.v - 0.1).abs() < 1e-12 && (robot.speed.omega + 0.3).abs() < 1e-12);
    for _ in 0..20 {
        robot.drive(Speed { v: 0.5, omega: 0.0 }, 0.1);
    }
    assert!((robot.speed.v - 0.5).abs() < 1e-12 && robot.speed.omega.abs() < 1e-12);
    // v reaction + v^2 / 2a
    assert!((robot.braking_m(0.1) - (0.05 + 0.125)).abs() < 1e-12);
    let quarter = Pose::default().after(Speed { v: 1.0, omega: 1.0 }, std::f64::consts::FRAC_PI_2);
    assert!(quarter.at.distance(DVec2::new(1.0, 1.0)) < 1e-12, "{quarter:?}");
    assert!((wrapped(-3.5) - (std::f64::consts::TAU - 3.5)).abs() < 1e-12);
}

#[test]
fn odometry_is_perfect_or_drifts_by_its_share() {
    let (mut exact, mut drifting) = (robot(0.0), robot(0.05));
    for _ in 0..200 {
        exact.drive(Speed { v: 0.5, omega: 0.1 }, 0.1);
        drifting.drive(Speed { v: 0.5, omega: 0.1 }, 0.1);
    }
    assert_eq!(exact.believed, exact.pose);
    assert_eq!(drifting.pose, exact.pose, "drift moves nothing");
    let off = drifting.believed.at.distance(drifting.pose.at);
    assert!((0.001..2.0).contains(&off), "{off}");
}

#[test]
fn runs_of_letters() {
    assert_eq!(runs("ffflluf".chars()), "f3l2u1f1");
    assert_eq!(runs("".chars()), "");
}
