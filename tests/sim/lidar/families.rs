//! The families for lidars: valid scenes by seed that hold what their name says.

use limpid::sim::Scene;
use limpid::sim::generate::{Family, Level, generate};
use limpid::sim::lidar::{Lidar, LidarModel};

use super::{pairs, scan_from};
use crate::support::gpu::skipped;

fn scene(family: Family, seed: u64) -> Scene {
    let mut scene = generate(family, Level::L0, seed, 10).unwrap();
    scene.lidar = Some(Lidar { model: LidarModel::Vlp16, rate_hz: 20.0, ..Lidar::default() });
    scene
}

#[test]
fn every_seed_gives_a_valid_scene_and_the_same_one_again() {
    for family in [Family::Glass, Family::Curtain, Family::Vegetation, Family::Thicket] {
        for seed in 1..7 {
            let one = scene(family, seed);
            one.validate().unwrap();
            assert_eq!(one, scene(family, seed));
            assert_ne!(one.materials, scene(family, seed + 100).materials, "{family:?}");
            assert_eq!(Scene::from_yaml(&one.to_yaml().unwrap()).unwrap().name, one.name);
        }
    }
}

/// Shares of the points of a scan from the way's start: glass, mirrored, behind glass, passable.
fn shares(family: Family, seed: u64) -> [f64; 4] {
    let scene = scene(family, seed);
    let pose = limpid::sim::poses(&scene)[0].map_from_base;
    let scan = scan_from(&scene, pose);
    let share = |pick: fn(&limpid::sim::lidar::PointTruth) -> bool| {
        pairs(&scan).filter(|(_, truth)| pick(truth)).count() as f64 / scan.truth.len() as f64
    };
    [
        share(|t| t.is_glass()),
        share(|t| t.is_reflection()),
        share(|t| t.is_behind()),
        share(|t| t.is_passable()),
    ]
}

#[test]
fn scans_hold_what_the_family_is_of() {
    if skipped() {
        return;
    }
    let pooled = |family| {
        (1..5)
            .map(|seed| shares(family, seed))
            .fold([0.0; 4], |sum, own| [0, 1, 2, 3].map(|i| sum[i] + own[i] / 4.0))
    };
    let [glass, mirrored, behind, passable] = pooled(Family::Glass);
    assert!(glass > 0.001 && mirrored > 0.002 && behind > 0.03 && passable == 0.0);
    for family in [Family::Curtain, Family::Vegetation, Family::Thicket] {
        let [.., passable] = pooled(family);
        assert!(passable > 0.01 && passable < 0.8, "{family:?}: {passable}");
    }
}

#[test]
fn the_open_air_has_no_ceiling_and_no_walls() {
    if skipped() {
        return;
    }
    let mut scene = scene(Family::Vegetation, 3);
    scene.thickets.clear();
    scene.boxes.clear();
    scene.cylinders.clear();
    let scan = scan_from(&scene, limpid::sim::poses(&scene)[0].map_from_base);
    assert!(pairs(&scan).all(|(_, truth)| truth.place_m.z.abs() < 0.01));
    assert!(scan.scan.points.iter().all(|point| point.ring < 8), "beams that look up return nothing");
}
