//! The family held out for evaluation: angled plans, pillars, round tables, other patterns and lights.

use glam::DVec2;

use super::layout::Layout;
use super::{Level, Physics, Random};
use crate::sim::footprint::Shape;
use crate::sim::material::{Material, Pattern};
use crate::sim::scene::{Block, Cylinder, Room, Scene};

const SURFACES: [&str; 4] = ["plaster", "checks", "stripes", "laminate"];

pub(super) fn scene(level: Level, random: &mut Random) -> Scene {
    let physics = Physics::drawn(level, random);
    let rooms = rooms(random);
    let mut layout = Layout::new(rooms, physics, random);
    materials(&mut layout);
    let glow = layout.random.within(8.0, 14.0);
    layout.lamps(3.0, [0.16, 1.5], [glow * 0.9, glow, glow * 1.05]);
    if physics.window_infrared > 0.0 {
        let daylight = layout.random.within(6.0, 16.0);
        for _ in 0..layout.random.count(2, 4) {
            let side = physics.window_m;
            layout.window(side * 0.4, side * 1.0, 1.4, [daylight, daylight * 0.95, daylight * 0.8]);
        }
    }
    for _ in 0..layout.random.count(2, 5) {
        layout.hang(1.2, 1.0, 1.3, "board");
    }
    if layout.random.chance(0.2) {
        layout.hang(1.0, 0.7, 1.4, "mirror");
    }
    if physics.glass {
        for _ in 0..layout.random.count(1, 2) {
            let width_m = layout.random.within(0.8, 1.4);
            layout.glass_pane(width_m, 2.2);
        }
    }
    furnish(&mut layout);
    layout.scene
}

/// An L, a T, or two rooms that a passage joins.
fn rooms(random: &mut Random) -> Vec<Room> {
    let room = |min_m, max_m| Room { min_m, max_m, walls: "walls".into() };
    let (a, b) = (random.within(5.5, 8.0), random.within(2.8, 4.0));
    let (c, d) = (random.within(2.6, 3.8), random.within(2.5, 4.0));
    match random.count(0, 2) {
        0 => vec![room([0.0, 0.0], [a, b]), room([0.0, b], [c, b + d])],
        1 => {
            let from = (a - c) * random.within(0.3, 0.7);
            vec![room([0.0, 0.0], [a, b]), room([from, b], [from + c, b + d])]
        }
        _ => {
            let from = random.within(0.4, b - 1.8);
            let far = a - c;
            vec![
                room([0.0, 0.0], [c, b + 0.8]),
                room([c, from], [far.max(c + 1.0), from + 1.4]),
                room([far.max(c + 1.0), -0.6], [far.max(c + 1.0) + c, b]),
            ]
        }
    }
}

fn materials(layout: &mut Layout<'_>) {
    let floor = layout.random.pick(&[Pattern::Checker, Pattern::Stripes, Pattern::None]);
    let scale_m = layout.random.within(0.15, 0.5);
    layout.floor(floor, scale_m);
    let tone = layout.random.within(0.35, 0.7);
    let pattern = layout.random.pick(&[Pattern::Tiles, Pattern::Stripes, Pattern::None]);
    let scale_m = layout.random.within(0.12, 0.4);
    layout.matt("walls", tone, pattern, scale_m);
    layout.matt("ceiling", 0.65, Pattern::Tiles, 0.6);
    layout.matt("board", 0.6, Pattern::Stripes, 0.07);
    layout.matt("plaster", 0.7, Pattern::None, 1.0);
    layout.matt("checks", 0.45, Pattern::Checker, 0.09);
    layout.matt("stripes", 0.5, Pattern::Stripes, 0.05);
    layout.matt("laminate", 0.25, Pattern::Tiles, 0.3);
    layout.scene.materials.insert("steel".into(), Material { roughness: 0.2, ..Material::metal() });
    layout.scene.materials.insert("mirror".into(), Material::mirror());
}

fn furnish(layout: &mut Layout<'_>) {
    let (mut wanted, mut trials) = (layout.random.count(4, 8), 0);
    while wanted > 0 && trials < 80 {
        trials += 1;
        let placed = match layout.random.count(0, 7) {
            0..=1 => pillar(layout),
            2..=3 => round_table(layout),
            _ => angled_block(layout),
        };
        wanted -= u32::from(placed);
    }
}

fn any_material(layout: &mut Layout<'_>) -> String {
    if layout.random.chance(0.1) { "steel".into() } else { layout.random.pick(&SURFACES).into() }
}

/// From floor to ceiling.
fn pillar(layout: &mut Layout<'_>) -> bool {
    let at = layout.anywhere();
    let radius_m = layout.random.within(0.10, 0.3);
    let (material, height_m) = (any_material(layout), layout.scene.ceiling_m);
    let cylinder = Cylinder { base_m: [at.x, at.y, 0.0], radius_m, height_m, material };
    layout.place_round(Shape::Disc(at, radius_m), 0.3, vec![cylinder])
}

/// A disc on one leg with a foot.
fn round_table(layout: &mut Layout<'_>) -> bool {
    let at = layout.anywhere();
    let (radius, height) = (layout.random.within(0.3, 0.6), layout.random.within(0.45, 1.05));
    let material = any_material(layout);
    let part = |radius_m: f64, from: f64, height_m: f64| Cylinder {
        base_m: [at.x, at.y, from],
        radius_m,
        height_m,
        material: material.clone(),
    };
    let parts = vec![
        part(radius, height - 0.03, 0.03),
        part(0.04, 0.02, height - 0.05),
        part(radius * 0.5, 0.0, 0.02),
    ];
    layout.place_round(Shape::Disc(at, radius), 0.2, parts)
}

/// A block at any angle, low or tall.
fn angled_block(layout: &mut Layout<'_>) -> bool {
    let at = layout.anywhere();
    let size_m =
        [layout.random.within(0.3, 1.3), layout.random.within(0.2, 0.7), layout.random.within(0.15, 1.9)];
    let yaw_rad = layout.random.within(0.0, std::f64::consts::PI);
    let half = DVec2::new(size_m[0], size_m[1]) / 2.0;
    let material = any_material(layout);
    let center_m = [at.x, at.y, size_m[2] / 2.0];
    let outline = Shape::Rectangle(at, half, DVec2::from_angle(yaw_rad));
    layout.place(outline, 0.12, vec![Block { center_m, size_m, yaw_rad, material }])
}
