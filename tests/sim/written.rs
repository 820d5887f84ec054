//! Solids written out as code give the bits that the tables give, and are written out where that is worth it alone.

use glam::DVec3;
use limpid::base::Rigid;
use limpid::sensor::Point;
use limpid::sim::generate::{Family, Level};
use limpid::sim::lidar::{Lidar, LidarSimulator};
use limpid::sim::walker::Walker;
use limpid::sim::{Scene, Simulator, generate};

use crate::support::gpu::{context, skipped};

/// So many that compiling is worth it, whatever the size.
const MANY: u64 = 1 << 30;

fn generated(family: Family, seed: u64) -> Scene {
    let mut scene = generate::generate(family, Level::L2, seed, 8).unwrap();
    (scene.camera.width, scene.camera.height) = (96, 64);
    scene
}

#[test]
fn a_frame_is_the_same_from_code_and_from_tables() {
    if skipped() {
        return;
    }
    // Walls, panes, boxes, cylinders; vessels, clear boxes, a cupboard's panes.
    for (family, seed) in [(Family::Train, 9), (Family::Vitrine, 4)] {
        let scene = generated(family, seed);
        let [table, code] = [1, MANY].map(|frames| {
            let mut simulator = Simulator::for_frames(&scene, &context(), frames).unwrap();
            let pose = simulator.poses()[3];
            simulator.frame(3, pose).unwrap()
        });
        assert!(table.true_depth_m.iter().any(|depth| *depth > 0.0));
        assert_eq!(table.infrared_left, code.infrared_left, "{family:?}");
        assert_eq!(table.rgb, code.rgb, "{family:?}");
        assert_eq!(table.depth_mm, code.depth_mm, "{family:?}");
        assert!(table.true_depth_m.iter().zip(&code.true_depth_m).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
}

#[test]
fn a_scan_is_the_same_from_code_and_from_tables() {
    if skipped() {
        return;
    }
    // Both have thin things of their kind.
    for family in [Family::Thicket, Family::Curtain] {
        same_scans(family);
    }
}

fn same_scans(family: Family) {
    let mut scene = generated(family, 6000);
    scene.lidar = Some(Lidar { subrays: 2, ..Lidar::default() });
    assert!(scene.thickets.len() + scene.curtains.len() > 0);
    let [table, code] = [1, MANY].map(|scans| {
        let mut simulator = LidarSimulator::for_scans(&scene, &context(), scans).unwrap();
        simulator.scan(0, 0, |_| Rigid::IDENTITY).unwrap()
    });
    assert!(table.scan.points.len() > 1000);
    assert_eq!(table.scan.points.len(), code.scan.points.len());
    let position = |point: &Point| point.position_m().map(f32::to_bits);
    assert!(table.scan.points.iter().map(position).eq(code.scan.points.iter().map(position)));
    assert!(table.truth == code.truth);
}

fn trajectory_start(scene: &Scene) -> Rigid {
    Simulator::for_frames(scene, &context(), 1).unwrap().poses()[0].map_from_base
}

#[test]
fn people_are_looked_up_in_tables() {
    if skipped() {
        return;
    }
    // What moves is not in the code: it would stand still.
    let mut scene = generated(Family::Train, 9);
    let pose = trajectory_start(&scene);
    let before = |side_m: f64| pose.transform_point(DVec3::new(0.8, side_m, 0.0)).truncate().to_array();
    let walker = Walker {
        waypoints_m: vec![before(-0.5), before(0.5)],
        speed_m_s: 1.0,
        ahead_s: 0.0,
        radius_m: 0.2,
        height_m: 1.7,
        material: scene.floor.clone(),
    };
    scene.walkers.push(walker);
    let mut simulator = Simulator::for_frames(&scene, &context(), MANY).unwrap();
    let pose = simulator.poses()[0];
    let [first, later] = [0, 20].map(|index| simulator.frame(index, pose).unwrap());
    assert_ne!(first.true_depth_m, later.true_depth_m);
}
