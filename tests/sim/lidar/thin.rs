//! Thickets and curtains: how often they are met, how deep beams go, what is seen beyond.

use limpid::sim::Scene;
use limpid::sim::scene::{Curtain, Outline, Thicket};

use super::{pairs, robot, room_with_lidar, scan_from, scan_of};
use crate::support::gpu::skipped;

/// A box of grass from x = 1 to x = 2.5 across the room, of that extinction.
fn with_grass(extinction_per_m: f64) -> Scene {
    let mut scene = room_with_lidar();
    scene.thickets.push(Thicket {
        center_m: [1.75, 0.0, 1.25],
        size_m: [1.5, 4.0, 2.5],
        yaw_rad: 0.0,
        outline: Outline::Box,
        density_per_m3: extinction_per_m / (0.5 * 0.004 * 0.25),
        element_width_m: 0.004,
        element_length_m: 0.25,
        material: "plain".into(),
        solid: false,
    });
    scene.lidar.as_mut().unwrap().returns = limpid::sim::lidar::Returns::Strongest;
    scene
}

/// Of the beams that cross the grass nearly head on: share that is returned by the wall behind.
fn share_through(scene: &Scene) -> f64 {
    let scan = scan_of(scene);
    let ahead: Vec<bool> = pairs(&scan)
        .filter(|(point, _)| {
            point.x_m > 0.0 && point.y_m.abs() < 0.15 * point.x_m && point.ring.abs_diff(8) < 4
        })
        .map(|(point, truth)| {
            assert!(truth.is_passable() == (truth.place_m.x < 2.51 && truth.place_m.x > 0.99), "{truth:?}");
            point.x_m > 2.8
        })
        .collect();
    assert!(ahead.len() > 100, "{}", ahead.len());
    ahead.iter().filter(|&&through| through).count() as f64 / ahead.len() as f64
}

#[test]
fn truth_beams_go_as_deep_as_the_density_lets_them() {
    if skipped() {
        return;
    }
    assert_eq!(share_through(&with_grass(0.0)), 1.0, "no elements");
    assert_eq!(share_through(&with_grass(1000.0)), 0.0, "a wall");
    // One sub-ray is a line: it passes 1.5 m with probability exp(-1.5 k).
    for extinction in [0.3, 1.0] {
        let mut scene = with_grass(extinction);
        scene.lidar.as_mut().unwrap().subrays = 1;
        let (share, want) = (share_through(&scene), (-1.5 * extinction).exp());
        assert!((share - want).abs() < 0.1, "{extinction}: {share} for {want}");
    }
}

#[test]
fn truth_ranges_in_a_thicket_fall_off_exponentially() {
    if skipped() {
        return;
    }
    let mut scene = with_grass(4.0);
    scene.lidar.as_mut().unwrap().subrays = 1;
    let scan = scan_of(&scene);
    let depths: Vec<f64> = pairs(&scan)
        .filter(|(point, truth)| truth.is_passable() && point.y_m.abs() < 0.15 * point.x_m)
        .map(|(_, truth)| truth.place_m.x - 1.0)
        .collect();
    let mean = depths.iter().sum::<f64>() / depths.len() as f64;
    assert!(depths.len() > 100 && (mean - 0.25).abs() < 0.06, "{mean} of {}", depths.len());
}

#[test]
fn a_bush_is_met_within_its_ellipsoid() {
    if skipped() {
        return;
    }
    let mut scene = with_grass(20.0);
    scene.thickets[0].outline = Outline::Ellipsoid;
    scene.thickets[0].solid = true;
    scene.thickets[0].yaw_rad = 0.3;
    let scan = scan_of(&scene);
    let inside = |place: glam::DVec3| {
        let local = glam::DQuat::from_rotation_z(-0.3) * (place - glam::DVec3::new(1.75, 0.0, 1.25));
        (local / glam::DVec3::new(0.75, 2.0, 1.25)).length()
    };
    let met = pairs(&scan).filter(|(_, truth)| inside(truth.place_m) < 1.01).count();
    assert!(met > 500, "{met}");
    assert!(pairs(&scan).all(|(_, truth)| !truth.is_passable()), "it is solid");
    let air =
        pairs(&scan).filter(|(_, t)| inside(t.place_m) >= 1.01 && t.place_m.x > 0.9 && t.place_m.x < 2.6);
    // Outside of the ellipsoid only the room's own surfaces remain.
    for (_, truth) in air {
        let at = truth.place_m;
        let off = [at.y - 2.0, at.y + 2.0, at.z, at.z - 2.5].map(f64::abs).into_iter().fold(9.0, f64::min);
        assert!(off < 0.01, "{truth:?}");
    }
}

#[test]
fn a_sensor_inside_a_thicket_sees_it_on_all_sides() {
    if skipped() {
        return;
    }
    let scene = with_grass(3.0);
    let pose = robot(1.75, 0.0, 0.0);
    let scan = scan_from(&scene, pose);
    let quadrants = [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)].map(|(x, y)| {
        pairs(&scan).filter(|(p, t)| t.is_passable() && p.x_m * x > 0.0 && p.y_m * y > 0.0).count()
    });
    assert!(quadrants.iter().all(|&count| count > 300), "{quadrants:?}");
}

/// A curtain across the room at x = 1.5.
fn with_curtain(spacing_m: f64, string_width_m: f64) -> Scene {
    let mut scene = room_with_lidar();
    scene.curtains.push(Curtain {
        center_m: [1.5, 0.0, 1.25],
        width_m: 4.0,
        height_m: 2.5,
        yaw_rad: 0.0,
        spacing_m,
        string_width_m,
        material: "plain".into(),
    });
    scene
}

#[test]
fn truth_strings_take_their_share_and_beams_that_meet_both_return_twice() {
    if skipped() {
        return;
    }
    let share = |scene: &Scene| {
        let scan = scan_of(scene);
        let ahead = |p: &limpid::sensor::Point| p.x_m > 0.0 && p.y_m.abs() < 0.15 * p.x_m;
        let all = pairs(&scan).filter(|(point, _)| ahead(point)).count();
        let strings: Vec<_> = pairs(&scan).filter(|(p, t)| ahead(p) && t.is_passable()).collect();
        assert!(strings.iter().all(|(_, truth)| (truth.place_m.x - 1.5).abs() < 0.01));
        (strings.len() as f64 / all as f64, all as f64 / scan.beams as f64)
    };
    let mut thin = with_curtain(0.05, 0.01);
    thin.lidar.as_mut().unwrap().subrays = 1;
    let (strings, _) = share(&thin);
    assert!((strings - 0.2).abs() < 0.06, "one line a beam: {strings}");
    // A footprint of 4.5 mm, strings of 5 mm every 20 mm: many beams meet a string and the wall.
    let (strings, all) = share(&with_curtain(0.02, 0.005));
    let (_, beams) = share(&room_with_lidar());
    assert!(strings > 0.2 && all > 1.1 * beams, "{strings} {all} {beams}");
    // Closer than they are wide: a wall.
    let (strings, _) = share(&with_curtain(0.01, 0.02));
    assert_eq!(strings, 1.0);
}
