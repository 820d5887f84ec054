//! People in scenes: where they are, what the sensors and the true map say of them.

use limpid::Config;
use limpid::sim::generate::{Family, Level, add_walkers, generate};
use limpid::sim::scene::Scene;
use limpid::sim::truth::{FREE, OCCUPIED, TrueMap, UNKNOWN};
use limpid::sim::walker::Walker;
use limpid::sim::{Simulator, poses};

use super::small_room;
use crate::support::gpu::skipped;

fn walker() -> Walker {
    Walker {
        waypoints_m: vec![[2.03, -1.2], [2.03, 1.2]],
        speed_m_s: 1.2,
        ahead_s: 0.0,
        radius_m: 0.2,
        height_m: 1.7,
        material: "walls".into(),
    }
}

#[test]
fn a_walker_goes_to_and_fro_at_its_pace() {
    let walker = walker();
    for (seconds, y) in [(0.0, -1.2), (0.5, -0.6), (2.0, 1.2), (3.0, 0.0), (4.0, -1.2), (4.5, -0.6)] {
        let place = walker.place_m(seconds);
        assert!((place.y - y).abs() < 1e-9 && place.x == 2.03, "{seconds} s: {place}");
    }
    let ahead = Walker { ahead_s: 0.5, ..walker.clone() };
    assert!((ahead.place_m(0.0).y + 0.6).abs() < 1e-9);
    let still = Walker { waypoints_m: vec![[1.0, 2.0]], ..walker };
    assert_eq!(still.place_m(7.0).to_array(), [1.0, 2.0]);
}

/// A robot that stands, and one who crosses before it, 10 frames a second.
fn crossed_room() -> Scene {
    let mut scene = small_room();
    (scene.camera.width, scene.camera.height) = (256, 144);
    scene.trajectory.rate_hz = 10.0;
    scene.trajectory.waypoints_m.truncate(1);
    scene.trajectory.frames = 21;
    scene.walkers.push(walker());
    scene
}

fn at(map: &TrueMap, x: f64, y: f64) -> i8 {
    let grid = map.grid();
    let column = ((x - grid.origin_x_m) / grid.resolution_m) as usize;
    let row = ((y - grid.origin_y_m) / grid.resolution_m) as usize;
    map.cells()[row * grid.width as usize + column]
}

#[test]
fn camera_and_truth_have_the_walker_where_it_is_and_not_where_it_was() {
    if skipped() {
        return;
    }
    let scene = crossed_room();
    let mut simulator = Simulator::open(&scene, None, false).unwrap();
    let mut map = TrueMap::new(&scene, &Config::default());
    let centre = |frame: &limpid::sim::frame::SimFrame| frame.true_depth_m[(72 * 256 + 128) as usize];
    let pose = poses(&scene)[0];
    let mut seen = Vec::new();
    // At -1.2 m, before the camera, and at 1.2 m.
    for index in [0, 10, 20] {
        let frame = simulator.frame(index, pose).unwrap();
        map.observe(&frame, &scene.camera.model());
        seen.push((centre(&frame), at(&map, 1.84, 0.0), at(&map, 2.03, 0.0), at(&map, 1.84, -1.2)));
    }
    let [(before, b_front, b_axis, _), (during, d_front, d_axis, _), (after, a_front, a_axis, _)] = seen[..]
    else {
        panic!()
    };
    assert!(before > during + 0.5 && (after - before).abs() < 1e-3, "{seen:?}");
    assert_eq!([b_front, d_front, a_front], [FREE, OCCUPIED, FREE], "the side that it shows");
    assert_eq!([b_axis, d_axis, a_axis], [FREE, UNKNOWN, FREE], "no surface of it lies there");
    assert_eq!(map.all_cells().iter().filter(|&&cell| cell == UNKNOWN).count(), {
        let none = Scene { walkers: Vec::new(), ..scene.clone() };
        TrueMap::new(&none, &Config::default()).all_cells().iter().filter(|&&cell| cell == UNKNOWN).count()
    });
}

#[test]
fn generated_walkers_keep_clear_of_the_robot_and_of_things() {
    let mut found = 0;
    for seed in 0..4 {
        let mut scene = generate(Family::Train, Level::L1, seed, 20).unwrap();
        found += add_walkers(&mut scene, 2);
        scene.validate().unwrap();
        let again = {
            let mut again = generate(Family::Train, Level::L1, seed, 20).unwrap();
            add_walkers(&mut again, 2);
            again
        };
        assert_eq!(scene, again);
        for walker in &scene.walkers {
            for tenth in 0..100 {
                let place = walker.place_m(f64::from(tenth) / 10.0);
                for pose in poses(&scene) {
                    assert!(pose.map_from_base.translation_m.truncate().distance(place) > 0.6);
                }
            }
        }
        assert_eq!(Scene::from_yaml(&scene.to_yaml().unwrap()).unwrap(), scene);
    }
    assert!(found >= 4, "{found} of 8");
}

#[test]
fn a_walker_that_cannot_be_is_refused_with_its_key() {
    for (change, key) in [
        (Walker { waypoints_m: Vec::new(), ..walker() }, "walkers[0].waypoints_m"),
        (Walker { speed_m_s: f64::NAN, ..walker() }, "walkers[0].speed_m_s"),
        (Walker { radius_m: 0.0, ..walker() }, "walkers[0].radius_m"),
        (Walker { material: "wool".into(), ..walker() }, "walkers[0].material"),
    ] {
        let mut scene = small_room();
        scene.walkers.push(change);
        let said = scene.validate().unwrap_err().to_string();
        assert!(said.contains(key), "{said}");
    }
    let mut crowd = small_room();
    crowd.walkers = vec![walker(); 17];
    assert!(crowd.validate().unwrap_err().to_string().contains("cylinders"));
}
