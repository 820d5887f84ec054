//! Clear vessels: tumblers, bowls, bottles, jars, domes and balls, empty, filled or solid.

use super::Random;
use super::layout::Layout;
use crate::sim::material::{Kind, Material};
use crate::sim::pack::{FRUSTUMS, VESSELS};
use crate::sim::vessel::Vessel;

/// A thin wall, a body that bends light, and two fillings.
const WALL: &str = "clear";
const BODY: &str = "body";
const FILLINGS: [&str; 2] = ["water", "drink"];

/// Adds what vessels are made of and filled with.
pub(super) fn materials(layout: &mut Layout<'_>) {
    let wall = Material {
        reflectance: layout.random.within(0.03, 0.08),
        transmission: layout.random.within(0.80, 0.97),
        ..Material::glass()
    };
    let body = Material {
        transmission: layout.random.within(0.93, 1.0),
        ..Material::clear(layout.random.within(1.45, 1.6))
    };
    let (albedo, albedo_ir) = layout.color(0.35, 0.8);
    let drink = Material { kind: Kind::Glossy, albedo, albedo_ir, reflectance: 0.04, ..Material::default() };
    let all = [(WALL, wall), (BODY, body), (FILLINGS[0], Material::clear(1.33)), (FILLINGS[1], drink)];
    layout.scene.materials.extend(all.map(|(name, material)| (name.into(), material)));
}

/// Puts a vessel there, where the tables have room for it.
pub(super) fn put(layout: &mut Layout<'_>, base_m: [f64; 3], radius_m: f64, height_m: f64) {
    let vessel = draw(layout.random, base_m, radius_m, height_m);
    let scene = &mut layout.scene;
    scene.vessels.push(vessel);
    let pieces: usize = scene.vessels.iter().map(|vessel| vessel.frustums(scene).len()).sum();
    if pieces > FRUSTUMS || scene.vessels.len() > VESSELS {
        scene.vessels.pop();
    }
}

fn draw(random: &mut Random, base_m: [f64; 3], radius_m: f64, height_m: f64) -> Vessel {
    let wall_m = random.within(0.0012, 0.004);
    let floor_m = random.within(0.003, 0.012);
    let kind = random.count(0, 5);
    let (corners, material): (Vec<[f64; 2]>, _) = match kind {
        0 => (tumbler(random.within(0.75, 1.0), wall_m / radius_m, floor_m / height_m), BODY),
        1 => (bowl(wall_m / radius_m, floor_m / height_m), BODY),
        2 => (bottle(random.within(0.25, 0.5), random.within(0.45, 0.7)), WALL),
        3 => (jar(random.within(0.6, 0.95)), WALL),
        4 => (dome(), random.pick(&[BODY, WALL])),
        _ => (ball(), random.pick(&[BODY, WALL])),
    };
    let profile_m = corners.into_iter().map(|[r, h]| [r * radius_m, h * height_m]).collect();
    let filled = kind < 4 && random.chance(0.45);
    let fill_m = filled.then(|| random.within(0.25, 0.44) * height_m);
    let contents = fill_m.map(|_| random.pick(&[FILLINGS[0], FILLINGS[0], FILLINGS[1]]).into());
    Vessel { base_m, profile_m, material: material.into(), fill_m, contents }
}

// Outlines as shares of radius and height.

fn tumbler(foot: f64, wall: f64, floor: f64) -> Vec<[f64; 2]> {
    vec![[0.0, 0.0], [foot, 0.0], [1.0, 1.0], [1.0 - wall, 1.0], [foot - wall, floor], [0.0, floor]]
}

fn bowl(wall: f64, floor: f64) -> Vec<[f64; 2]> {
    let floor = floor.min(0.2);
    vec![
        [0.0, 0.0],
        [0.5, 0.0],
        [0.85, 0.35],
        [1.0, 1.0],
        [1.0 - wall, 1.0],
        [0.84 - wall, 0.38],
        [0.45, floor],
        [0.0, floor],
    ]
}

fn bottle(neck: f64, shoulder: f64) -> Vec<[f64; 2]> {
    vec![[0.0, 0.0], [1.0, 0.0], [1.0, shoulder], [neck, shoulder + 0.2], [neck, 1.0]]
}

/// With a lid.
fn jar(neck: f64) -> Vec<[f64; 2]> {
    vec![[0.0, 0.0], [1.0, 0.0], [1.0, 0.8], [neck, 0.9], [neck, 1.0], [0.0, 1.0]]
}

fn dome() -> Vec<[f64; 2]> {
    vec![[0.0, 0.0], [1.0, 0.0], [0.9, 0.4], [0.6, 0.8], [0.0, 1.0]]
}

fn ball() -> Vec<[f64; 2]> {
    vec![[0.0, 0.0], [0.6, 0.1], [1.0, 0.36], [1.0, 0.64], [0.6, 0.9], [0.0, 1.0]]
}
