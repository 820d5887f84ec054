//! The family to drive through: corridors, halls and halls with a glass front, 12 to 16 m long (spec 7 §2).

use glam::DVec2;

use super::layout::Layout;
use super::{Level, Physics, Random, glazed, train};
use crate::sim::footprint::Shape;
use crate::sim::material::Material;
use crate::sim::scene::{Block, Curtain, Cylinder, Room, Scene};

/// What a scene is, by its seed in turn.
#[derive(Clone, Copy, PartialEq)]
enum Plan {
    Corridor,
    Hall,
    GlassFront,
}

pub(super) fn scene(level: Level, seed: u64, random: &mut Random) -> Scene {
    let physics = Physics::drawn(level, random);
    let plan = [Plan::Corridor, Plan::Hall, Plan::GlassFront][(seed % 3) as usize];
    let (length, across) = (random.within(12.0, 16.0), random.within(5.0, 8.0));
    let rooms = rooms(plan, length, across, random);
    let mut layout = Layout::new(rooms, physics, random);
    train::materials(&mut layout);
    let glow = layout.random.within(5.0, 9.0);
    layout.lamps(3.2, [0.6, 0.6], [glow, glow * 0.95, glow * 0.85]);
    if plan == Plan::GlassFront {
        glazed::front(&mut layout, length, across);
    }
    windows(&mut layout);
    for _ in 0..layout.random.count(2, 5) {
        let (width_m, height_m) = (layout.random.within(0.4, 1.1), layout.random.within(0.3, 0.9));
        layout.hang(width_m, height_m, 1.5, "picture");
    }
    if plan == Plan::Hall {
        pillars(&mut layout);
        train::furnish(&mut layout);
    }
    train::furnish(&mut layout);
    layout.scene
}

/// A corridor with a bend or a bay, a hall, or a hall with a strip of floor behind its glass.
fn rooms(plan: Plan, length: f64, across: f64, random: &mut Random) -> Vec<Room> {
    let room = |min_m, max_m, walls: &str| Room { min_m, max_m, walls: walls.into() };
    match plan {
        Plan::Corridor => {
            let width = random.within(2.0, 2.8);
            let mut rooms = vec![room([0.0, 0.0], [length, width], "corridor")];
            if random.chance(0.5) {
                let end = width + random.within(3.0, 5.0);
                rooms.push(room([length - width, width], [length, end], "corridor"));
            } else {
                let from = random.within(0.2, 0.5) * length;
                rooms.push(room([from, width], [from + 4.0, width + 2.0], "walls"));
            }
            rooms
        }
        Plan::Hall => vec![room([0.0, 0.0], [length, across], "walls")],
        Plan::GlassFront => {
            let behind = across + random.within(1.5, 3.0);
            vec![room([0.0, 0.0], [length, across], "walls"), room([0.0, across], [length, behind], "walls")]
        }
    }
}

/// Windows as rooms to train on have them, for twice the floor.
fn windows(layout: &mut Layout<'_>) {
    if layout.physics.window_infrared > 0.0 {
        let daylight = layout.random.within(4.0, 12.0);
        for _ in 0..layout.random.count(2, 4) {
            let side = layout.physics.window_m;
            layout.window(side, side * 0.85, 1.45, [daylight, daylight, daylight * 1.1]);
        }
    }
}

fn pillars(layout: &mut Layout<'_>) {
    for _ in 0..layout.random.count(0, 3) {
        let at = layout.anywhere();
        let radius_m = layout.random.within(0.15, 0.3);
        let height_m = layout.scene.ceiling_m;
        let pillar = Cylinder { base_m: [at.x, at.y, 0.0], radius_m, height_m, material: "paint".into() };
        layout.place_round(Shape::Disc(DVec2::new(at.x, at.y), radius_m), 0.6, vec![pillar]);
    }
}

/// A hall that a wall parts; the only way through is closed by a curtain of strings. One of its sides is glass.
pub(super) fn mixed(level: Level, random: &mut Random) -> Scene {
    let physics = Physics::drawn(level, random);
    let (length, across) = (random.within(11.0, 14.0), random.within(5.0, 7.0));
    let rooms = rooms(Plan::GlassFront, length, across, random);
    let mut layout = Layout::new(rooms, physics, random);
    train::materials(&mut layout);
    let beads = layout.random.within(0.2, 0.8);
    layout.scene.materials.insert("beads".into(), Material::diffuse([0.5, 0.3, 0.2], beads));
    layout.lamps(3.2, [0.6, 0.6], [6.0, 5.7, 5.2]);
    glazed::front(&mut layout, length, across);
    windows(&mut layout);
    parted(&mut layout, length, across);
    train::furnish(&mut layout);
    layout.scene
}

/// A wall across the hall with a doorway of 1.4 to 1.8 m, and a curtain in it.
fn parted(layout: &mut Layout<'_>, length: f64, across: f64) {
    const THICK_M: f64 = 0.12;
    let x = layout.random.within(0.4, 0.6) * length;
    let (width, middle) = (layout.random.within(1.4, 1.8), layout.random.within(0.35, 0.65) * across);
    let (ceiling_m, sides) =
        (layout.scene.ceiling_m, [[0.0, middle - width / 2.0], [middle + width / 2.0, across]]);
    for [from, to] in sides {
        let center_m = [x, f64::midpoint(from, to), ceiling_m / 2.0];
        let size_m = [THICK_M, to - from, ceiling_m];
        layout.scene.boxes.push(Block { center_m, size_m, yaw_rad: 0.0, material: "paint".into() });
    }
    let height_m = layout.random.within(2.0, 2.3);
    layout.scene.curtains.push(Curtain {
        center_m: [x, middle, height_m / 2.0 + 0.05],
        width_m: width,
        height_m,
        yaw_rad: 0.0,
        spacing_m: layout.random.within(0.02, 0.07),
        string_width_m: layout.random.within(0.003, 0.009),
        material: "beads".into(),
    });
}
