//! Generated scenes: valid, repeatable, different by seed, level and family.

use glam::DVec3;
use limpid::sim::generate::{Family, Level, Physics, generate, vary_sensor};
use limpid::sim::{Scene, poses};

const FRAMES: u32 = 40;

fn scene(family: Family, level: Level, seed: u64) -> Scene {
    generate(family, level, seed, FRAMES).unwrap()
}

#[test]
fn scenes_are_valid_repeatable_and_survive_yaml() {
    for family in [Family::Train, Family::HeldOut, Family::Tabletop, Family::Vitrine] {
        for level in [Level::L0, Level::L1, Level::L2] {
            for seed in 0..12 {
                let scene = scene(family, level, seed);
                scene.validate().unwrap();
                assert_eq!(scene, self::scene(family, level, seed));
                assert_eq!(Scene::from_yaml(&scene.to_yaml().unwrap()).unwrap(), scene);
                assert!(scene.boxes.len() + scene.cylinders.len() >= 3, "{} is bare", scene.name);
            }
        }
    }
    let (a, b) = (scene(Family::Train, Level::L1, 1), scene(Family::Train, Level::L1, 2));
    assert_ne!((a.rooms, a.boxes), (b.rooms, b.boxes));
}

#[test]
fn the_way_keeps_to_the_spec() {
    for seed in 0..10 {
        let scene = scene(Family::Train, Level::L2, seed);
        let poses = poses(&scene);
        assert_eq!(poses.len(), FRAMES as usize);
        for pair in poses.windows(2) {
            let [a, b] = [0, 1].map(|i| pair[i].map_from_base);
            assert!(a.translation_m.distance(b.translation_m) <= 0.04 + 1e-9);
            assert!(a.rotation.angle_between(b.rotation) <= scene.trajectory.turn_rad + 1e-9);
        }
        assert!((0.25..0.40).contains(&scene.camera.pitch_rad));
        assert!((0.35..0.60).contains(&scene.camera.height_m));
        let travel = poses[0].map_from_base.translation_m;
        assert!(poses.iter().any(|p| p.map_from_base.translation_m.distance(travel) > 0.1) || seed > 0);
    }
}

#[test]
fn levels_differ_in_light_and_gloss_alone() {
    let physics = |level| Physics::of(level);
    let (l0, l1, l2) = (physics(Level::L0), physics(Level::L1), physics(Level::L2));
    assert!(l0.floor_reflectance == 0.0 && l0.window_infrared == 0.0 && !l0.glass);
    assert!(l1.floor_reflectance < l2.floor_reflectance && l1.window_infrared < l2.window_infrared);
    for seed in 0..6 {
        let [a, b, c] = [Level::L0, Level::L1, Level::L2].map(|level| scene(Family::Train, level, seed));
        assert!(a.windows.is_empty() && !b.windows.is_empty() && !c.windows.is_empty());
        assert_eq!((&a.matcher, &a.imager), (&b.matcher, &b.imager));
        assert_eq!((&b.matcher, &b.imager), (&c.matcher, &c.imager));
    }
    let glass = |seed| scene(Family::Train, Level::L2, seed).panes.iter().any(|p| p.material == "glass");
    assert!((0..6).filter(|&seed| glass(seed)).count() >= 4);
}

#[test]
fn families_share_no_material_but_glass_and_mirror_and_sensors_vary_by_seed() {
    let (train, held) = (scene(Family::Train, Level::L1, 4), scene(Family::HeldOut, Level::L1, 4));
    let common: Vec<_> =
        train.materials.keys().filter(|name| held.materials.contains_key(*name)).cloned().collect();
    assert_eq!(common, ["ceiling", "floor", "glass", "mirror", "walls"]);
    assert_ne!(train.materials["floor"].pattern, held.materials["floor"].pattern);
    let (mut a, mut b) = (train.clone(), train.clone());
    vary_sensor(&mut a);
    vary_sensor(&mut b);
    assert_eq!(a, b);
    a.validate().unwrap();
    assert_ne!((&a.matcher, &a.imager), (&train.matcher, &train.imager));
    b.seed = 5;
    vary_sensor(&mut b);
    assert_ne!(a.matcher, b.matcher);
}

#[test]
fn a_way_that_is_too_long_is_refused() {
    let error = generate(Family::Train, Level::L0, 1, 90_000).unwrap_err().to_string();
    assert!(error.contains("`seed`") && error.contains("90000 frames"), "{error}");
}

#[test]
fn a_generated_scene_knows_its_level_and_another_has_none() {
    for level in [Level::L0, Level::L1, Level::L2] {
        for family in [Family::Train, Family::HeldOut, Family::Tabletop] {
            assert_eq!(Level::of_scene(&scene(family, level, 2)), Some(level));
        }
    }
    let mut other = scene(Family::Train, Level::L1, 2);
    for name in ["", "kitchen", "Train L1", "Train L3 seed 2", "Train L1 seed 2 again"] {
        other.name = name.into();
        assert_eq!(Level::of_scene(&other), None, "{name}");
    }
}

#[test]
fn a_table_is_seen_from_close_by_through_clear_vessels() {
    for seed in 0..12 {
        let scene = scene(Family::Tabletop, Level::L0, seed);
        let panes = scene.panes.iter().filter(|pane| pane.material == "clear");
        assert!(panes.clone().count() % 6 == 0, "{}", scene.name);
        let of_panes = panes.map(|pane| (DVec3::from(pane.center_m), pane.center_m[2] - pane.height_m / 2.0));
        let round = scene.vessels.iter().map(|vessel| (DVec3::from(vessel.base_m), vessel.base_m[2]));
        let clear: Vec<_> = of_panes.chain(round).collect();
        let top_m = scene.boxes[0].center_m[2] + 0.02;
        assert!(clear.len() >= 2 && clear.iter().all(|(_, foot_m)| (foot_m - top_m).abs() < 1e-9));
        for pose in poses(&scene) {
            let camera = pose.map_from_base.then(pose.base_from_camera);
            let nearest = clear.iter().map(|(place, _)| camera.translation_m.distance(*place));
            let nearest = nearest.fold(f64::INFINITY, f64::min);
            assert!((0.2..2.5).contains(&nearest), "{}: {nearest} m", scene.name);
        }
    }
}

#[test]
fn tables_and_vitrines_draw_every_kind() {
    let pool = |family| -> Vec<Scene> { (0..40).map(|seed| scene(family, Level::L1, seed)).collect() };
    let tables = pool(Family::Tabletop);
    let of_panes = |s: &&Scene| s.vessels.is_empty() && s.panes.iter().any(|pane| pane.material == "clear");
    assert!(tables.iter().filter(of_panes).count() >= 3, "the table of flat panes is among the draws");
    let vessels: Vec<_> = tables.iter().flat_map(|s| &s.vessels).collect();
    for material in ["clear", "body"] {
        assert!(vessels.iter().filter(|v| v.material == material).count() > 10, "{material}");
    }
    for contents in ["water", "drink"] {
        assert!(vessels.iter().any(|v| v.contents.as_deref() == Some(contents)), "{contents}");
    }
    let vitrines = pool(Family::Vitrine);
    assert!(vitrines.iter().filter(|s| s.sun.is_some()).count() >= 15);
    let of_box = |s: &Scene, material: &str| s.boxes.iter().any(|b| b.material == material);
    for material in ["water", "steel", "black", "foil", "goods"] {
        assert!(vitrines.iter().filter(|s| of_box(s, material)).count() >= 5, "{material}");
    }
    let front = |s: &&Scene| s.panes.iter().any(|pane| pane.material == "glass");
    assert!(vitrines.iter().filter(front).count() >= 20);
}
