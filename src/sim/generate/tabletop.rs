//! The family of clear things on a table, seen from close by: for training beside the rooms.

use std::f64::consts::{PI, SQRT_2, TAU};

use glam::DVec2;

use super::layout::Layout;
use super::{Level, Physics, Random, shiny, vessels};
use crate::sim::material::Pattern;
use crate::sim::scene::{Block, Cylinder, Pane, Room, Scene};

/// Sides of a vessel of flat panes.
const SIDES: u32 = 6;

/// A table top: its middle is the map's origin.
struct Table {
    half_m: [f64; 2],
    height_m: f64,
}

pub(super) fn scene(level: Level, frames: u32, random: &mut Random) -> Scene {
    let physics = Physics::drawn(level, random);
    let (width, depth) = (random.within(4.0, 7.0), random.within(4.0, 6.0));
    let (min_m, max_m) = ([-width / 2.0, -depth / 2.0], [width / 2.0, depth / 2.0]);
    let mut layout = Layout::new(vec![Room { min_m, max_m, walls: "walls".into() }], physics, random);
    materials(&mut layout);
    let glow = layout.random.within(5.0, 12.0);
    layout.lamps(3.0, [0.5, 0.5], [glow, glow * 0.95, glow * 0.85]);
    if physics.window_infrared > 0.0 {
        let side = physics.window_m;
        layout.window(side, side * 0.85, 1.45, [8.0, 8.0, 9.0]);
    }
    let table = Table {
        half_m: [layout.random.within(0.55, 0.7), layout.random.within(0.35, 0.6)],
        height_m: layout.random.within(0.4, 0.75),
    };
    build(&mut layout.scene, &table);
    lay_table(&mut layout, &table);
    if layout.random.chance(0.6) {
        put_behind(&mut layout, &table);
    }
    look_down(&mut layout, &table, frames);
    layout.scene
}

fn materials(layout: &mut Layout<'_>) {
    let floor = layout.random.pick(&[Pattern::Tiles, Pattern::Planks, Pattern::Clouds]);
    layout.floor(floor, 0.5);
    layout.matt("walls", 0.6, Pattern::Clouds, 0.5);
    layout.matt("ceiling", 0.75, Pattern::None, 1.0);
    let pattern = layout.random.pick(&[Pattern::Planks, Pattern::Clouds, Pattern::None, Pattern::Tiles]);
    let (tone, scale_m) = (layout.random.within(0.1, 0.8), layout.random.within(0.03, 0.3));
    layout.matt("table", tone, pattern, scale_m);
    layout.matt("dish", 0.5, Pattern::Clouds, 0.03);
    shiny::materials(layout);
    vessels::materials(layout);
    if layout.random.chance(0.25) {
        let top = layout.random.pick(&["black", "steel", "goods", "label"]);
        let top = layout.scene.materials[top].clone();
        layout.scene.materials.insert("table".into(), top);
    }
}

fn build(scene: &mut Scene, table: &Table) {
    let [x, y] = table.half_m;
    let top = [0.0, 0.0, table.height_m - 0.02];
    let block = |center_m, size_m| Block { center_m, size_m, yaw_rad: 0.0, material: "table".into() };
    scene.boxes.push(block(top, [2.0 * x, 2.0 * y, 0.04]));
    let tall = table.height_m - 0.04;
    for (sx, sy) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        scene.boxes.push(block([sx * (x - 0.05), sy * (y - 0.05), tall / 2.0], [0.06, 0.06, tall]));
    }
}

/// Clear vessels and a few things that are not clear, where there is room.
fn lay_table(layout: &mut Layout<'_>, table: &Table) {
    let mut taken: Vec<(DVec2, f64)> = Vec::new();
    let (clear, others) = (layout.random.count(4, 9), layout.random.count(0, 4));
    let flat_share = layout.random.pick(&[0.0, 0.0, 0.3, 1.0]);
    for thing in 0..clear + others {
        let radius_m = layout.random.within(0.025, 0.07);
        let at = DVec2::new(
            layout.random.within(-0.7, 0.5) * table.half_m[0],
            layout.random.within(-0.8, 0.8) * table.half_m[1],
        );
        if taken.iter().any(|&(other, radius)| at.distance(other) < radius + radius_m + 0.01) {
            continue;
        }
        taken.push((at, radius_m));
        let base_m = at.extend(table.height_m).to_array();
        let height_m = layout.random.within(0.04, 0.18);
        let flat = layout.random.chance(flat_share);
        let yaw_rad = layout.random.within(0.0, TAU);
        if thing < clear && flat {
            vessel(&mut layout.scene, base_m, radius_m, height_m, yaw_rad);
        } else if thing < clear {
            let tall = if layout.random.chance(0.3) { 1.7 } else { 1.0 };
            vessels::put(layout, base_m, radius_m, tall * height_m);
        } else {
            opaque(layout, base_m, radius_m, height_m, yaw_rad);
        }
    }
}

/// A dish, a tin, a packet.
fn opaque(layout: &mut Layout<'_>, base_m: [f64; 3], radius_m: f64, height_m: f64, yaw_rad: f64) {
    let material = layout.random.pick(&["dish", "label", "foil", "steel", "black"]).into();
    if layout.random.chance(0.6) {
        let height_m = 0.6 * height_m;
        layout.scene.cylinders.push(Cylinder { base_m, radius_m, height_m, material });
        return;
    }
    let [x, y, z] = base_m;
    let (center_m, side_m) = ([x, y, z + height_m / 2.0], radius_m * SQRT_2);
    let size_m = [side_m, side_m * layout.random.within(0.4, 1.0), height_m];
    layout.scene.boxes.push(Block { center_m, size_m, yaw_rad, material });
}

/// Books, packets or a board along the far edge, right behind what is clear.
fn put_behind(layout: &mut Layout<'_>, table: &Table) {
    let [x, y] = table.half_m;
    let mut at = -y;
    while at < y - 0.02 {
        let width_m = layout.random.within(0.04, 0.5).min(y - at);
        let size_m = [layout.random.within(0.02, 0.12), width_m - 0.002, layout.random.within(0.08, 0.4)];
        let place_x = x - 0.07 - layout.random.within(0.0, 0.05);
        let center_m = [place_x, at + width_m / 2.0, table.height_m + size_m[2] / 2.0];
        let material = layout.random.pick(&["goods", "label", "goods", "dish", "black", "foil"]).into();
        if layout.scene.boxes.len() < 40 {
            layout.scene.boxes.push(Block { center_m, size_m, yaw_rad: 0.0, material });
        }
        at += width_m;
    }
}

/// An upright prism of clear panes.
fn vessel(scene: &mut Scene, base_m: [f64; 3], radius_m: f64, height_m: f64, turn_rad: f64) {
    let half_angle = PI / f64::from(SIDES);
    for side in 0..SIDES {
        let yaw_rad = turn_rad + TAU * f64::from(side) / f64::from(SIDES);
        let face = DVec2::from_angle(yaw_rad) * radius_m * half_angle.cos();
        scene.panes.push(Pane {
            center_m: [base_m[0] + face.x, base_m[1] + face.y, base_m[2] + height_m / 2.0],
            width_m: 2.0 * radius_m * half_angle.sin(),
            height_m,
            yaw_rad,
            material: "clear".into(),
        });
    }
}

/// An arm holds the camera over the table's edge; the robot drives up to it.
fn look_down(layout: &mut Layout<'_>, table: &Table, frames: u32) {
    let camera = &mut layout.scene.camera;
    camera.forward_m = layout.random.within(0.2, 0.45);
    camera.height_m = table.height_m + layout.random.within(0.35, 0.75);
    camera.pitch_rad = layout.random.within(0.6, 1.0);
    let way = &mut layout.scene.trajectory;
    let (stop_m, side_m) = (table.half_m[0] + way.clearance_m + 0.02, layout.random.within(-0.15, 0.15));
    let length_m = f64::from(frames) * way.step_m;
    way.waypoints_m = vec![[-stop_m - length_m, side_m], [-stop_m, side_m]];
}
