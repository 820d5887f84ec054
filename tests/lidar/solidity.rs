//! Learned solidity through the product: whatever the scale of intensities, and without any.

use glam::DVec3;
use limpid::Config;
use limpid::base::Rigid;
use limpid::config::Solidity;
use limpid::map::CellClass;
use limpid::sensor::{Columns, Point, Scan, SensorPose};
use limpid::sim::Scene;
use limpid::sim::lidar::{Lidar, LidarModel, LidarSimulator, PointTruth};
use limpid::sim::material::Material;
use limpid::sim::scene::{Block, Outline, Room, Thicket};

use crate::sim::small_room;
use crate::support::gpu::{context, skipped};
use crate::support::scan::{ScanFrame, ScanOutput, cell, open, point, posed, run_one, step};

/// A yard with walls, a thin post, a box of a person's size, and tall grass behind the robot.
fn yard() -> Scene {
    let mut scene = small_room();
    let materials = [("walls", 0.4), ("floor", 0.3), ("post", 0.5), ("person", 0.45), ("grass", 0.5)];
    for (name, infrared) in materials {
        scene.materials.insert(name.into(), Material::diffuse([infrared; 3], infrared));
    }
    scene.rooms = vec![Room { min_m: [-6.0, -5.0], max_m: [5.0, 5.0], walls: "walls".into() }];
    let block = |at: [f64; 2], size_m: [f64; 3], material: &str| Block {
        center_m: [at[0], at[1], 0.5 * size_m[2]],
        size_m,
        yaw_rad: 0.2,
        material: material.into(),
    };
    scene.boxes =
        vec![block([3.0, 1.0], [0.12, 0.12, 1.3], "post"), block([2.5, -1.5], [0.3, 0.5, 1.75], "person")];
    scene.thickets.push(Thicket {
        center_m: [-3.0, 0.0, 0.35],
        size_m: [3.0, 4.0, 0.7],
        yaw_rad: 0.0,
        outline: Outline::Box,
        density_per_m3: 3000.0,
        element_width_m: 0.005,
        element_length_m: 0.3,
        material: "grass".into(),
        solid: false,
    });
    scene.lidar = Some(Lidar { model: LidarModel::Hdl32e, height_m: 0.9, ..Lidar::default() });
    scene
}

fn pose(scene: &Scene) -> SensorPose {
    let base_from_sensor = scene.lidar.as_ref().unwrap().base_from_lidar();
    SensorPose { map_from_base: Rigid::IDENTITY, base_from_sensor, sweep: None }
}

/// A scan with the material of each of its points.
fn scan_of(scene: &Scene) -> (Scan, Vec<PointTruth>) {
    let mut simulator = LidarSimulator::with_context(scene, &context()).unwrap();
    let simulated = simulator.scan(0, 1_000_000_000, |_| Rigid::IDENTITY).unwrap();
    (simulated.scan, simulated.truth)
}

fn config() -> Config {
    Config {
        layer_heights_m: vec![-1.0, 0.0, 1.0],
        inflation_length_m: 0.0,
        inflation_side_m: 0.0,
        inscribed_radius_m: 0.0,
        ..Config::default()
    }
}

fn run(scan: Scan, pose: SensorPose, config: &Config) -> ScanOutput {
    run_one(config, &posed(scan, pose))
}

/// Of the cells in which points of a material stand, 0.15 m to 1.8 m high: how many there are, and how many are of that class.
fn called(out: &ScanOutput, scene: &Scene, truth: &[PointTruth], name: &str, class: CellClass) -> [usize; 2] {
    let number = scene.materials.keys().position(|known| known == name).unwrap();
    let of = truth.iter().filter(|truth| usize::from(truth.material) == number);
    let places = of.map(|truth| truth.place_m).filter(|at| (0.15..1.8).contains(&at.z));
    let mut cells: Vec<usize> = places.map(|at: DVec3| cell(out, at.x, at.y)).collect();
    cells.sort_unstable();
    cells.dedup();
    [cells.len(), cells.iter().filter(|&&cell| out.classes[cell] == class as u8).count()]
}

fn brightened(scan: &Scan, gain: Option<f32>) -> Scan {
    let columns = Columns { intensity: gain.is_some(), ..scan.columns };
    let points = scan.points.iter();
    let points = points.map(|point| Point { intensity: point.intensity * gain.unwrap_or(0.0), ..*point });
    Scan { points: points.collect(), columns, ..scan.clone() }
}

#[test]
fn walls_posts_and_people_are_solid_and_grass_is_passable_whatever_the_brightness() {
    if skipped() {
        return;
    }
    let scene = yard();
    let (scan, truth) = scan_of(&scene);
    let (mut all, mut grass) = (Vec::new(), Vec::new());
    for gain in [Some(1.0), Some(1.0 / 255.0), Some(257.0), None] {
        let out = run(brightened(&scan, gain), pose(&scene), &config());
        for name in ["post", "person"] {
            let [there, passable] = called(&out, &scene, &truth, name, CellClass::Passable);
            assert!(there > 2 && passable == 0, "{name} at {gain:?}: {passable} of {there}");
        }
        let [there, passable] = called(&out, &scene, &truth, "walls", CellClass::Passable);
        assert!(there > 200 && 50 * passable < there, "walls at {gain:?}: {passable} of {there}");
        let [there, passable] = called(&out, &scene, &truth, "grass", CellClass::Passable);
        assert!(there > 100 && 2 * passable > there, "grass at {gain:?}: {passable} of {there}");
        grass.push(passable);
        all.push(out.classes);
    }
    // Powers of two apart, so that not even rounding differs.
    let twice = run(brightened(&scan, Some(4.0)), pose(&scene), &config());
    assert_eq!(twice.classes, all[0], "a factor changes nothing");
    assert!(grass[0].abs_diff(grass[1]) < 3 && grass[0].abs_diff(grass[2]) < 3, "{grass:?}");
}

#[test]
fn gamma_decides_which_rule_auto_is() {
    if skipped() {
        return;
    }
    let scene = yard();
    let (scan, _) = scan_of(&scene);
    let note = |config: &Config| open(config, &posed(scan.clone(), pose(&scene))).mapper.notes()[0].clone();
    assert!(note(&config()).contains("(solidity: learned)"), "{}", note(&config()));
    let stated = Config { gamma: Some(0.3), ..config() };
    assert!(!note(&stated).contains("learned"), "{}", note(&stated));
    assert!(note(&Config { solidity: Solidity::Learned, ..stated }).contains("(solidity: learned)"));
    let by_intensity = Config { solidity: Solidity::Intensity, ..config() };
    assert!(note(&by_intensity).starts_with("full scale"), "{}", note(&by_intensity));
}

/// Passable cells in which something stands higher than the floor.
fn passable_above(out: &ScanOutput, points: &[DVec3]) -> usize {
    let mut cells: Vec<usize> = points
        .iter()
        .filter(|at| at.z > 0.15 && at.x.abs() < 9.0 && at.y.abs() < 9.0)
        .map(|at| cell(out, at.x, at.y))
        .collect();
    cells.sort_unstable();
    cells.dedup();
    cells.iter().filter(|&&cell| out.classes[cell] == CellClass::Passable as u8).count()
}

#[test]
fn what_says_nothing_makes_nothing_passable() {
    if skipped() {
        return;
    }
    let scene = yard();
    let (scan, _) = scan_of(&scene);
    // One ring alone: a flat scan.
    let rings: Vec<Point> = scan.points.iter().filter(|point| point.ring == 23).copied().collect();
    let flat = Scan { points: rings, ..scan.clone() };
    let place = |scan: &Scan, pose: SensorPose| -> Vec<DVec3> {
        let of = |point: &Point| DVec3::from(point.position_m().map(f64::from));
        scan.points.iter().map(|point| pose.map_from_sensor().transform_point(of(point))).collect()
    };
    let out = run(flat.clone(), pose(&scene), &config());
    assert!(out.count(CellClass::Solid) > 50);
    assert_eq!(passable_above(&out, &place(&flat, pose(&scene))), 0, "flat");
    // Nobody says where the lidar is, and too little of the floor is there to find it.
    let high: Vec<Point> = scan.points.iter().filter(|point| point.z_m > 0.1).copied().collect();
    let lost = Scan { points: high, ..scan };
    let out = run(lost, SensorPose::SENSOR, &config());
    assert!(out.count(CellClass::Solid) > 100);
    assert_eq!(out.count(CellClass::Passable), 0, "no ground");
}

#[test]
fn odd_brightness_is_none_and_large_scans_work() {
    if skipped() {
        return;
    }
    let scene = yard();
    let (scan, _) = scan_of(&scene);
    let without = run(brightened(&scan, None), pose(&scene), &config()).classes;
    for odd in [0.0, 77.0, -3.0, 65535.0] {
        let points = scan.points.iter().map(|point| Point { intensity: odd, ..*point }).collect();
        let out = run(Scan { points, ..scan.clone() }, pose(&scene), &config());
        assert_eq!(out.classes, without, "{odd} in every return");
    }
    // 128 rings of 2048 columns all around, a wall.
    let beam = |column: u32, ring: u32| {
        let (turn, up) = (f64::from(column) * 0.003068, (f64::from(ring) - 64.0) * 0.006);
        point([3.0 * turn.cos(), 3.0 * turn.sin(), 3.0 * up], f64::from(column % 200))
    };
    let points: Vec<Point> =
        (0..128).flat_map(|ring| (0..2048).map(move |column| beam(column, ring))).collect();
    let large = Config { max_points: 300_000, ..config() };
    let frame: ScanFrame = posed(crate::support::scan::scan(0, points), pose(&scene));
    let out = step(&mut open(&large, &frame), &frame);
    assert!(out.count(CellClass::Solid) > 150 && out.count(CellClass::Passable) == 0, "a wall all around");
}

#[test]
fn a_lidar_upside_down_sees_the_same_solid_things() {
    if skipped() {
        return;
    }
    let mut scene = yard();
    let lidar = Lidar { tilt_rad: [std::f64::consts::PI, 0.0, 0.0], ..scene.lidar.clone().unwrap() };
    // Its beams that reached the floor now reach up: it hangs higher.
    scene.lidar = Some(Lidar { height_m: 1.6, ..lidar });
    let (scan, truth) = scan_of(&scene);
    let out = run(scan, pose(&scene), &config());
    for (name, least) in [("post", 1), ("person", 2), ("walls", 200)] {
        let [there, passable] = called(&out, &scene, &truth, name, CellClass::Passable);
        assert!(there > least && 50 * passable < there, "{name}: {passable} of {there}");
    }
}

#[test]
fn a_lidar_in_a_thicket_and_a_thicket_that_is_a_wall_hide_no_solid_thing() {
    if skipped() {
        return;
    }
    for (density_per_m3, height_m) in [(3000.0, 0.5), (0.0, 0.5), (2.0e5, 0.5), (2.0e5, 0.9)] {
        let mut scene = yard();
        scene.thickets[0].center_m = [0.0, 0.0, 0.35];
        scene.thickets[0].density_per_m3 = density_per_m3;
        scene.lidar = Some(Lidar { height_m, ..scene.lidar.clone().unwrap() });
        let (scan, truth) = scan_of(&scene);
        let out = run(scan, pose(&scene), &config());
        // Through grass few beams reach what stands behind, so that now and then a cell of it is taken for grass.
        for (name, of) in [("person", 4), ("walls", 20)] {
            let [there, passable] = called(&out, &scene, &truth, name, CellClass::Passable);
            let at = format!("{name} at {density_per_m3}, {height_m} m");
            assert!(of * passable <= there, "{at}: {passable} of {there}");
        }
    }
}
