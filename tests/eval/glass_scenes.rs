//! Scores of drives past glass, on a room that is easy.

use std::f64::consts::PI;

use limpid::Config;
use limpid::offline::eval::glass_scenes::{DriveTally, PoseNoise, drive};
use limpid::offline::labeller::Labeller;
use limpid::sim::generate::{Family, Level, generate};
use limpid::sim::lidar::{Lidar, LidarModel, LidarSimulator};
use limpid::sim::material::Material;
use limpid::sim::scene::{Pane, Room};
use limpid::sim::{Scene, Way};

use crate::sim::{a_box, small_room};
use crate::support::gpu::{context, skipped};

/// A room of 7 m by 6 m whose side at x = 3 is of coated glass, with another room behind; a robot drives along the glass.
fn hall() -> Scene {
    let mut scene = small_room();
    for name in ["walls", "floor", "plain"] {
        scene.materials.insert(name.into(), Material::diffuse([0.5; 3], 0.6));
    }
    let coated = Material { reflectance: 0.15, transmission: 0.6, ..Material::glass() };
    scene.materials.insert("glass".into(), coated);
    let room = |min_m, max_m| Room { min_m, max_m, walls: "walls".into() };
    scene.rooms = vec![room([-4.0, -3.0], [3.0, 3.0]), room([3.0, -3.0], [6.0, 3.0])];
    scene.panes.push(Pane {
        center_m: [3.0, 0.0, 1.25],
        width_m: 6.0,
        height_m: 2.5,
        yaw_rad: PI,
        material: "glass".into(),
    });
    scene.boxes.push(a_box([-2.0, 2.0, 0.5], [0.8, 0.8, 1.0]));
    scene.boxes.push(a_box([-1.0, -2.4, 0.5], [0.5, 0.5, 1.0]));
    scene.trajectory.waypoints_m = vec![[0.0, -1.2], [0.0, 1.2]];
    scene.trajectory.rate_hz = 10.0;
    scene.trajectory.frames = 60;
    scene.lidar = Some(Lidar { model: LidarModel::Hdl32e, subrays: 8, rate_hz: 10.0, ..Lidar::default() });
    scene
}

#[test]
fn truth_a_glass_front_is_found_and_its_reflections_go_back_to_where_they_belong() {
    if skipped() {
        return;
    }
    let config = Config { glass_memory: true, ..Config::default() };
    let noises = [PoseNoise::default(), PoseNoise { place_m: 0.5, yaw_rad: 0.0 }];
    let mut tallies = [DriveTally::default(), DriveTally::default()];
    drive(&hall(), &config, 8, &context(), (&noises, &mut tallies)).unwrap();
    let [right, wrong] = tallies.map(|tally| (tally.scans, tally.scores()));
    assert_eq!((right.0, wrong.0), (8, 8));
    let scores = right.1;
    assert!(scores.pane_recall > 0.5 && scores.pane_precision > 0.9, "{scores:?}");
    assert!(scores.pane_off_m < 0.03, "{scores:?}");
    assert!(scores.points.reflections_left < 0.3 && scores.points.normal_lost < 0.02, "{scores:?}");
    assert!(scores.mirrored_in_place > 0.7, "{scores:?}");
    // The control: poses that are half a metre off put mirrored points and panes elsewhere.
    assert!(wrong.1.pane_off_m > 0.03 || wrong.1.pane_recall < 0.5 * scores.pane_recall, "{:?}", wrong.1);
}

#[test]
fn a_scene_without_a_lidar_is_refused() {
    if skipped() {
        return;
    }
    let scene = Scene { lidar: None, ..hall() };
    let mut tallies = [DriveTally::default()];
    let error = drive(&scene, &Config::default(), 2, &context(), (&[PoseNoise::default()], &mut tallies));
    assert!(error.unwrap_err().to_string().contains("lidar"));
    assert_eq!(tallies[0].scores().pane_recall, 0.0);
}

#[test]
fn truth_a_curtain_of_strings_is_no_pane() {
    if skipped() {
        return;
    }
    let config = Config { glass_memory: false, ..Config::default() };
    for seed in [5900, 5903, 5905] {
        let mut scene = generate(Family::Curtain, Level::L0, seed, 30).unwrap();
        scene.lidar = Some(Lidar { model: LidarModel::Vlp16, ..Lidar::default() });
        let way = Way::of(&scene);
        let mut simulator = LidarSimulator::with_context(&scene, &context()).unwrap();
        let (simulated, _) = simulator.next_on(&way, u64::MAX).unwrap().unwrap();
        let scan = simulated.scan;
        let mut labeller = Labeller::on(&context(), &config, &scan).unwrap();
        let labelled = labeller.label(&scan, limpid::base::Rigid::IDENTITY).unwrap();
        let counters = labelled.counters;
        assert!(counters.dual_returns > 100 && counters.refused_planes > 0, "{seed}: {counters:?}");
        assert_eq!(counters.found_panes, 0, "{seed}: {:?}", labelled.panes);
    }
}
