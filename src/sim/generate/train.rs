//! The family to train on: rectangular rooms, some with a corridor.

use std::f64::consts::FRAC_PI_2;

use glam::DVec2;

use super::layout::Layout;
use super::{Level, Physics, Random};
use crate::sim::footprint::Shape;
use crate::sim::material::{Material, Pattern};
use crate::sim::scene::{Block, Cylinder, Room, Scene};

const FURNITURE: [&str; 4] = ["wood", "paint", "fabric", "dark"];

pub(super) fn scene(level: Level, random: &mut Random) -> Scene {
    let physics = Physics::drawn(level, random);
    let rooms = rooms(random);
    let mut layout = Layout::new(rooms, physics, random);
    materials(&mut layout);
    let daylight = layout.random.within(4.0, 12.0);
    let glow = layout.random.within(5.0, 9.0);
    layout.lamps(3.2, [0.6, 0.6], [glow, glow * 0.95, glow * 0.85]);
    if physics.window_infrared > 0.0 {
        for _ in 0..layout.random.count(1, 2) {
            let side = physics.window_m;
            layout.window(side, side * 0.85, 1.45, [daylight, daylight, daylight * 1.1]);
        }
    }
    for _ in 0..layout.random.count(2, 4) {
        let (width_m, height_m) = (layout.random.within(0.4, 1.1), layout.random.within(0.3, 0.9));
        layout.hang(width_m, height_m, 1.5, "picture");
    }
    if layout.random.chance(0.2) {
        layout.hang(0.6, 1.4, 1.0, "mirror");
    }
    if physics.glass {
        let mut trials = 0;
        while layout.scene.panes.iter().all(|pane| pane.material != "glass") && trials < 20 {
            trials += 1;
            let width_m = layout.random.within(1.0, 1.8);
            layout.glass_pane(width_m, 2.0);
        }
    }
    furnish(&mut layout);
    layout.scene
}

fn rooms(random: &mut Random) -> Vec<Room> {
    let (width, depth) = (random.within(5.0, 8.0), random.within(4.2, 6.5));
    let (x, y) = (-width / 2.0, -depth / 2.0);
    let room = |min_m, max_m, walls: &str| Room { min_m, max_m, walls: walls.into() };
    let mut rooms = vec![room([x, y], [x + width, y + depth], "walls")];
    if random.chance(0.4) {
        let (from, across) = (random.within(x + 0.3, x + width - 2.3), random.within(1.6, 2.0));
        let end = y + depth + random.within(2.5, 5.0);
        rooms.push(room([from, y + depth], [from + across, end], "corridor"));
    }
    rooms
}

pub(super) fn materials(layout: &mut Layout<'_>) {
    let floor = layout.random.pick(&[Pattern::Tiles, Pattern::Planks, Pattern::Clouds]);
    let scale_m = layout.random.within(0.3, 0.8);
    layout.floor(floor, scale_m);
    let tone = layout.random.within(0.5, 0.75);
    let pattern = layout.random.pick(&[Pattern::Clouds, Pattern::None, Pattern::Clouds]);
    layout.matt("walls", tone, pattern, 0.5);
    layout.matt("corridor", tone, Pattern::Clouds, 0.3);
    layout.matt("ceiling", 0.75, Pattern::None, 1.0);
    layout.matt("picture", 0.5, Pattern::Clouds, 0.12);
    layout.matt("wood", 0.35, Pattern::Planks, 0.4);
    layout.matt("paint", 0.6, Pattern::None, 1.0);
    layout.matt("fabric", 0.4, Pattern::Clouds, 0.06);
    layout.matt("dark", 0.12, Pattern::Clouds, 0.2);
    layout.scene.materials.insert("metal".into(), Material::metal());
    layout.scene.materials.insert("mirror".into(), Material::mirror());
}

pub(super) fn furnish(layout: &mut Layout<'_>) {
    let (mut wanted, mut trials) = (layout.random.count(5, 9), 0);
    while wanted > 0 && trials < 80 {
        trials += 1;
        let placed = match layout.random.count(0, 9) {
            0..=3 => cabinet(layout),
            4..=5 => crate_box(layout),
            6..=7 => table(layout),
            _ => bin(layout),
        };
        wanted -= u32::from(placed);
    }
}

fn any_material(layout: &mut Layout<'_>) -> String {
    if layout.random.chance(0.08) { "metal".into() } else { layout.random.pick(&FURNITURE).into() }
}

/// Stands against a wall.
fn cabinet(layout: &mut Layout<'_>) -> bool {
    let (width, depth) = (layout.random.within(0.5, 1.4), layout.random.within(0.3, 0.6));
    let height = layout.random.within(0.4, 2.0);
    let Some((wall, facing)) = layout.on_a_wall(width) else { return false };
    let at = wall + DVec2::from_angle(facing) * (depth / 2.0 + 0.02);
    let yaw_rad = facing - FRAC_PI_2;
    let outline = Shape::Rectangle(at, DVec2::new(width, depth) / 2.0 - 0.01, DVec2::from_angle(yaw_rad));
    let material = any_material(layout);
    let center_m = [at.x, at.y, height / 2.0];
    layout.place(outline, 0.004, vec![Block { center_m, size_m: [width, depth, height], yaw_rad, material }])
}

/// Stands anywhere.
pub(super) fn crate_box(layout: &mut Layout<'_>) -> bool {
    let at = layout.anywhere();
    let size_m = [0.25, 0.25, 0.2].map(|least| layout.random.within(least, 3.0 * least));
    let yaw_rad = layout.random.within(0.0, FRAC_PI_2);
    let half = DVec2::new(size_m[0], size_m[1]) / 2.0;
    let material = any_material(layout);
    let center_m = [at.x, at.y, size_m[2] / 2.0];
    let outline = Shape::Rectangle(at, half, DVec2::from_angle(yaw_rad));
    layout.place(outline, 0.25, vec![Block { center_m, size_m, yaw_rad, material }])
}

/// A top on four legs.
fn table(layout: &mut Layout<'_>) -> bool {
    let at = layout.anywhere();
    let (width, depth, height) =
        (layout.random.within(0.8, 1.5), layout.random.within(0.6, 0.9), layout.random.within(0.6, 0.8));
    let yaw_rad = layout.random.pick(&[0.0, FRAC_PI_2]);
    let turn = DVec2::from_angle(yaw_rad);
    let material = any_material(layout);
    let mut boxes = vec![Block {
        center_m: [at.x, at.y, height - 0.02],
        size_m: [width, depth, 0.04],
        yaw_rad,
        material: material.clone(),
    }];
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        let leg = at + turn.rotate(DVec2::new(x * (width / 2.0 - 0.05), y * (depth / 2.0 - 0.05)));
        let tall = height - 0.04;
        let (center_m, size_m) = ([leg.x, leg.y, tall / 2.0], [0.06, 0.06, tall]);
        boxes.push(Block { center_m, size_m, yaw_rad, material: material.clone() });
    }
    layout.place(Shape::Rectangle(at, DVec2::new(width, depth) / 2.0, turn), 0.2, boxes)
}

fn bin(layout: &mut Layout<'_>) -> bool {
    let at = layout.anywhere();
    let (radius_m, height_m) = (layout.random.within(0.12, 0.25), layout.random.within(0.3, 1.2));
    let material = any_material(layout);
    let cylinder = Cylinder { base_m: [at.x, at.y, 0.0], radius_m, height_m, material };
    layout.place_round(Shape::Disc(at, radius_m), 0.2, vec![cylinder])
}
