//! Depth by stereo: noise on a plane, virtual images in mirrors and on polished floors.

use glam::DVec3;
use limpid::sim::Simulator;
use limpid::sim::material::{Kind, Material};
use limpid::sim::rates::Rates;
use limpid::sim::scene::{Pane, Scene, Window};

use super::{first_pose, look, median, middle, small_room};
use crate::support::gpu::skipped;

/// Disparity errors against a depth, pixels.
fn disparity_errors(scene: &Scene, depths_mm: &[u16], true_m: f64) -> Vec<f64> {
    let focal_baseline = scene.camera.model().fx * scene.camera.baseline_m;
    let valid = depths_mm.iter().filter(|&&mm| mm > 0);
    valid.map(|&mm| focal_baseline / (f64::from(mm) * 1e-3) - focal_baseline / true_m).collect()
}

#[test]
fn a_textured_wall_is_measured_within_the_noise_of_a_subpixel_fit() {
    if skipped() {
        return;
    }
    let mut scene = small_room();
    // Disparities that are no whole numbers: 32.1 px m / 3 m = 10.7 px.
    scene.camera.baseline_m = 0.5;
    scene.imager.projector = 20.0;
    let frame = look(&scene);
    let depths = middle(&frame, &frame.depth_mm, 0.18);
    let truth = middle(&frame, &frame.true_depth_m, 0.18);
    assert!(truth.iter().all(|&depth| (depth - 3.0).abs() < 1e-4), "the wall is 3 m away");
    let errors = disparity_errors(&scene, &depths, 3.0);
    assert!(errors.len() * 10 > depths.len() * 8, "{} of {} pixels are valid", errors.len(), depths.len());
    let spread = median(errors.iter().map(|e| e.abs()).collect());
    assert!(spread < 0.12, "median error {spread} px");
    assert!(median(errors.clone()).abs() < 0.08, "bias {} px", median(errors));
    // The control: another wall's depth does not pass.
    let wrong = disparity_errors(&scene, &depths, 2.9);
    assert!(median(wrong.iter().map(|e| e.abs()).collect()) > 0.12);
}

#[test]
fn without_projector_and_texture_there_is_no_depth() {
    if skipped() {
        return;
    }
    let mut scene = small_room();
    scene.materials.insert("walls".into(), Material::default());
    scene.imager.projector = 0.0;
    scene.camera.baseline_m = 0.5;
    let right = |scene: &Scene| {
        let errors = disparity_errors(scene, &middle(&look(scene), &look(scene).depth_mm, 0.18), 3.0);
        errors.iter().filter(|error| error.abs() < 0.5).count()
    };
    let pixels = middle(&look(&scene), &look(&scene).depth_mm, 0.18).len();
    let by_chance = right(&scene);
    assert!(by_chance * 10 < pixels * 2, "{by_chance} of {pixels}");
    scene.imager.projector = 20.0;
    let found = right(&scene);
    assert!(found * 10 > pixels * 7, "the projector makes up for it: {found} of {pixels}");
}

#[test]
fn a_mirror_shows_the_virtual_image_at_its_depth() {
    if skipped() {
        return;
    }
    let mut scene = small_room();
    scene.camera.baseline_m = 0.5;
    scene.materials.insert("walls".into(), super::textured(0.5));
    let yaw_rad = std::f64::consts::PI;
    let material = "mirror".into();
    scene.panes.push(Pane { center_m: [1.5, 0.0, 0.7], width_m: 2.0, height_m: 1.4, yaw_rad, material });
    let frame = look(&scene);
    let truth = middle(&frame, &frame.true_depth_m, 0.3);
    assert!(truth.iter().all(|&depth| (depth - 1.5).abs() < 1e-4), "the mirror itself is the truth");
    assert!(middle(&frame, &frame.material, 0.3).iter().all(|&code| code == Kind::Mirror.code()));
    // The wall behind the robot, 3 m back, appears 1.5 + 1.5 + 3 m ahead.
    let errors = disparity_errors(&scene, &middle(&frame, &frame.depth_mm, 0.3), 6.0);
    assert!(errors.len() * 2 > truth.len(), "{} of {} pixels are valid", errors.len(), truth.len());
    assert!(median(errors.clone()).abs() < 0.15, "{} px off the virtual wall", median(errors));
}

/// A floor before a sunlit wall.
fn hall(reflectance: f64, albedo: f64) -> Scene {
    let mut scene = small_room();
    let floor = Material { kind: Kind::Glossy, reflectance, ..Material::diffuse([albedo; 3], albedo) };
    scene.materials.insert("floor".into(), floor);
    scene.materials.insert("walls".into(), super::textured(0.4));
    scene.camera = limpid::sim::settings::Camera {
        width: 256,
        height: 144,
        pitch_rad: 0.35,
        baseline_m: 0.15,
        ..scene.camera
    };
    scene.matcher.disparities = 128;
    let color = [10.0; 3];
    let yaw_rad = -std::f64::consts::FRAC_PI_2;
    let center_m = [0.0, 1.99, 1.5];
    scene.windows.push(Window { center_m, width_m: 2.0, height_m: 1.0, yaw_rad, color, infrared: 20.0 });
    scene
}

/// Pixels whose true surface is the floor, and those of them whose depth lies clearly below it.
fn below_the_floor(scene: &Scene) -> (usize, usize) {
    let mut simulator = Simulator::open(scene, None, false).unwrap();
    let pose = first_pose(scene);
    let frame = simulator.frame(0, pose).unwrap();
    let camera = scene.camera.model();
    let map_from_camera = pose.map_from_base.then(pose.base_from_camera);
    let (mut floor, mut below) = (0, 0);
    for (pixel, (&truth, &mm)) in (0_u32..).zip(frame.true_depth_m.iter().zip(&frame.depth_mm)) {
        let (u, v) = (f64::from(pixel % camera.width), f64::from(pixel / camera.width));
        let ray = DVec3::new((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
        let at = |depth: f64| map_from_camera.transform_point(ray * depth).z;
        if at(truth.into()).abs() < 1e-3 && truth > 0.0 {
            floor += 1;
            below += usize::from(mm > 0 && at(f64::from(mm) * 1e-3) < -0.1);
        }
    }
    (floor, below)
}

#[test]
fn a_polished_floor_shows_the_room_below_it() {
    if skipped() {
        return;
    }
    let (floor, below) = below_the_floor(&hall(0.2, 0.03));
    assert!(below * 5 > floor, "{below} of {floor} floor pixels are virtual images");
    let (floor, below) = below_the_floor(&hall(0.0, 0.4));
    assert!(below * 20 < floor, "the control, a matt floor: {below} of {floor}");
}

#[test]
fn noise_grows_with_range_and_rates_count_it() {
    if skipped() {
        return;
    }
    let deviation = |far: f64| {
        let mut scene = small_room();
        scene.rooms[0].max_m[0] = far;
        scene.camera.baseline_m = 0.3;
        scene.matcher.disparities = 256;
        scene.imager.projector = 40.0;
        let frame = look(&scene);
        let errors = middle(&frame, &frame.depth_mm, 0.12);
        let errors = errors.iter().filter(|&&mm| mm > 0).map(|&mm| (f64::from(mm) * 1e-3 - far).abs());
        median(errors.collect())
    };
    let (near, away) = (deviation(1.2), deviation(4.8));
    assert!(away > 4.0 * near, "{near} m at 1.2 m, {away} m at 4.8 m");
}

#[test]
fn the_same_seed_gives_the_same_bytes() {
    if skipped() {
        return;
    }
    let mut scene = hall(0.1, 0.03);
    let (first, second) = (look(&scene), look(&scene));
    assert_eq!(first, second);
    let mut simulator = Simulator::open(&scene, None, false).unwrap();
    let pose = first_pose(&scene);
    let later = simulator.frame(1, pose).unwrap();
    assert_ne!(later.infrared_left, first.infrared_left, "noise differs from frame to frame");
    assert_eq!(later.true_depth_m, first.true_depth_m);
    assert_eq!(simulator.frame(0, pose).unwrap(), first, "whatever was done before");
    scene.seed = 2;
    assert_ne!(look(&scene).infrared_left, first.infrared_left);
}

#[test]
fn rates_count_holes_spikes_and_errors() {
    let mut frame = limpid::sim::frame::SimFrame {
        index: 0,
        stamp_ns: 0,
        pose: first_pose(&small_room()),
        width: 4,
        height: 2,
        depth_mm: vec![0, 2000, 2300, 2000, 100, 12_000, 1000, 2150],
        rgb: vec![],
        infrared_left: vec![],
        infrared_right: vec![],
        true_depth_m: vec![2.0, 2.0, 2.0, 0.0, 2.0, 2.0, 2.0, 2.0],
        material: vec![],
    };
    let rates = Rates::of(&frame);
    assert_eq!((rates.pixels, rates.valid, rates.compared, rates.spikes), (8, 5, 4, 2));
    assert!((rates.hole_rate() - 3.0 / 8.0).abs() < 1e-12 && (rates.spike_rate() - 0.5).abs() < 1e-12);
    let want = ((0.09_f64 + 1.0 + 0.0225) / 4.0).sqrt();
    assert!((rates.rmse_m() - want).abs() < 1e-6, "{}", rates.rmse_m());
    let mut both = rates;
    both.add(&rates);
    assert_eq!((both.pixels, both.rmse_m()), (16, rates.rmse_m()));
    frame.depth_mm.clear();
    frame.true_depth_m.clear();
    let nothing = Rates::of(&frame);
    assert_eq!((nothing.hole_rate(), nothing.spike_rate(), nothing.rmse_m()), (0.0, 0.0, 0.0));
}
