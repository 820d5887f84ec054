//! The families of grass, bushes and trees, apart or intertwined, and of string curtains in narrow passages.
//!
//! Reflectivities at 850 to 940 nm: leaves and grass .45 to .55, bark .25 to .35, soil .2 to .3, cloth and beads .2 to .8
//! (spec 6 section 1).

use glam::DVec2;

use super::layout::Layout;
use super::{Level, Physics, Random, train};
use crate::sim::footprint::Shape;
use crate::sim::material::{Kind, Material, Pattern};
use crate::sim::scene::{Block, Curtain, Cylinder, Outline, Room, Scene, Thicket};

/// Side of the meadow, metres.
const MEADOW_M: f64 = 24.0;

/// Grass, bushes and trees in the open; `intertwined`: tall grass around and between the others.
pub(super) fn meadow(level: Level, intertwined: bool, random: &mut Random) -> Scene {
    let physics = Physics::drawn(level, random);
    let half = MEADOW_M / 2.0;
    let room = Room { min_m: [-half; 2], max_m: [half; 2], walls: "soil".into() };
    let mut layout = Layout::new(vec![room], physics, random);
    layout.scene.open_air = true;
    layout.scene.ceiling_m = 20.0;
    layout.scene.ambient.color = [2.0, 2.2, 2.6];
    plants(&mut layout);
    for _ in 0..layout.random.count(3, 5) {
        tree(&mut layout);
    }
    for _ in 0..layout.random.count(4, 7) {
        bush(&mut layout, if intertwined { 0.1 } else { 1.2 });
    }
    for _ in 0..layout.random.count(1, 3) {
        post(&mut layout);
    }
    for _ in 0..layout.random.count(5, 8) {
        grass(&mut layout, intertwined);
    }
    layout.scene
}

fn plants(layout: &mut Layout<'_>) {
    for (name, color, infrared, spread) in [
        ("floor", [0.12, 0.09, 0.05], 0.25, 0.05),
        ("soil", [0.12, 0.09, 0.05], 0.25, 0.05),
        ("grass", [0.08, 0.18, 0.04], 0.5, 0.05),
        ("leaf", [0.05, 0.14, 0.03], 0.5, 0.05),
        ("bark", [0.14, 0.10, 0.07], 0.3, 0.05),
        ("post", [0.5, 0.5, 0.5], 0.5, 0.25),
    ] {
        let albedo_ir = infrared + layout.random.within(-spread, spread);
        let pattern = if name == "grass" || name == "leaf" { Pattern::None } else { Pattern::Clouds };
        let kind = if pattern == Pattern::None { Kind::Diffuse } else { Kind::Textured };
        let material = Material {
            kind,
            pattern,
            pattern_albedo: color.map(|c| 0.7 * c),
            pattern_albedo_ir: 0.8 * albedo_ir,
            pattern_scale_m: 0.4,
            ..Material::diffuse(color, albedo_ir)
        };
        layout.scene.materials.insert(name.into(), material);
    }
    layout.scene.materials.insert("ceiling".into(), Material::diffuse([0.6, 0.7, 0.9], 0.3));
}

/// A trunk with a crown above the robot.
fn tree(layout: &mut Layout<'_>) {
    let at = layout.anywhere();
    let radius_m = layout.random.within(0.08, 0.3);
    let height_m = layout.random.within(2.5, 4.0);
    let trunk = Cylinder { base_m: [at.x, at.y, 0.0], radius_m, height_m, material: "bark".into() };
    if !layout.place_round(Shape::Disc(at, radius_m), 2.0, vec![trunk]) {
        return;
    }
    let (across, tall) = (layout.random.within(2.0, 4.0), layout.random.within(1.6, 3.0));
    layout.scene.thickets.push(Thicket {
        center_m: [at.x, at.y, height_m.max(1.8) + tall / 2.0 - 0.3],
        size_m: [across, across * layout.random.within(0.8, 1.2), tall],
        yaw_rad: layout.random.within(0.0, 3.0),
        outline: Outline::Ellipsoid,
        density_per_m3: layout.random.within(800.0, 2500.0),
        element_width_m: 0.04,
        element_length_m: 0.07,
        material: "leaf".into(),
        solid: true,
    });
}

/// Twigs and leaves, dense enough that a robot does not pass.
fn bush(layout: &mut Layout<'_>, gap_m: f64) {
    let at = layout.anywhere();
    let half = DVec2::new(layout.random.within(0.4, 0.9), layout.random.within(0.4, 0.9));
    let (yaw_rad, height) = (layout.random.within(0.0, 3.0), layout.random.within(0.7, 1.6));
    let thicket = Thicket {
        center_m: [at.x, at.y, height / 2.0 - 0.1],
        size_m: [2.0 * half.x, 2.0 * half.y, height + 0.2],
        yaw_rad,
        outline: Outline::Ellipsoid,
        density_per_m3: layout.random.within(2500.0, 8000.0),
        element_width_m: layout.random.within(0.02, 0.04),
        element_length_m: layout.random.within(0.03, 0.06),
        material: "leaf".into(),
        solid: true,
    };
    let outline = Shape::Oval(at, half, DVec2::from_angle(yaw_rad));
    if layout.place_thicket(outline, gap_m, thicket) && layout.random.chance(0.7) {
        let stem = Cylinder {
            base_m: [at.x, at.y, 0.0],
            radius_m: 0.03,
            height_m: height * 0.8,
            material: "bark".into(),
        };
        layout.scene.cylinders.push(stem);
    }
}

/// A post, a bench, a sign: solid without doubt.
fn post(layout: &mut Layout<'_>) {
    let at = layout.anywhere();
    let (width, height) = (layout.random.within(0.1, 0.5), layout.random.within(0.8, 1.8));
    let yaw_rad = layout.random.within(0.0, 1.5);
    let outline = Shape::Rectangle(at, DVec2::splat(width / 2.0), DVec2::from_angle(yaw_rad));
    let (center_m, size_m) = ([at.x, at.y, height / 2.0], [width, width, height]);
    layout.place(outline, 0.8, vec![Block { center_m, size_m, yaw_rad, material: "post".into() }]);
}

/// A patch that a robot passes; between other plants it is tall and may overlap them.
fn grass(layout: &mut Layout<'_>, intertwined: bool) {
    let at = layout.anywhere();
    let half = DVec2::new(layout.random.within(0.8, 2.5), layout.random.within(0.8, 2.5));
    let yaw_rad = layout.random.within(0.0, 3.0);
    let height = if intertwined { layout.random.within(0.4, 1.2) } else { layout.random.within(0.2, 0.8) };
    let thicket = Thicket {
        center_m: [at.x, at.y, height / 2.0],
        size_m: [2.0 * half.x, 2.0 * half.y, height],
        yaw_rad,
        outline: Outline::Box,
        density_per_m3: layout.random.within(1500.0, 10_000.0),
        element_width_m: layout.random.within(0.004, 0.008),
        element_length_m: layout.random.within(0.2, 0.4),
        material: "grass".into(),
        solid: false,
    };
    if intertwined {
        layout.scene.thickets.push(thicket);
        return;
    }
    layout.place_thicket(Shape::Rectangle(at, half, DVec2::from_angle(yaw_rad)), 0.5, thicket);
}

/// A passage closed by one or two curtains of strings.
pub(super) fn passage(level: Level, random: &mut Random) -> Scene {
    let physics = Physics::drawn(level, random);
    let (length, width) = (random.within(9.0, 14.0), random.within(1.5, 2.4));
    let ends = [random.within(3.0, 4.5), random.within(3.0, 4.5)];
    let room = |min_m, max_m| Room { min_m, max_m, walls: "walls".into() };
    let rooms = vec![
        room([0.0, -ends[0] / 2.0], [4.0, ends[0] / 2.0]),
        room([4.0, -width / 2.0], [4.0 + length, width / 2.0]),
        room([4.0 + length, -ends[1] / 2.0], [8.0 + length, ends[1] / 2.0]),
    ];
    let mut layout = Layout::new(rooms, physics, random);
    train::materials(&mut layout);
    let beads = layout.random.within(0.2, 0.8);
    layout.scene.materials.insert("beads".into(), Material::diffuse([0.5, 0.3, 0.2], beads));
    layout.lamps(3.2, [0.6, 0.6], [6.0, 5.7, 5.2]);
    for number in 0..layout.random.count(1, 2) {
        let at = layout.random.within(0.2, 0.45) + 0.4 * f64::from(number);
        let height_m = layout.random.within(2.0, 2.3);
        layout.scene.curtains.push(Curtain {
            center_m: [4.0 + at * length, 0.0, height_m / 2.0 + 0.05],
            width_m: width,
            height_m,
            yaw_rad: layout.random.within(-0.1, 0.1),
            spacing_m: layout.random.within(0.02, 0.07),
            string_width_m: layout.random.within(0.003, 0.009),
            material: "beads".into(),
        });
    }
    train::furnish(&mut layout);
    layout.scene
}
