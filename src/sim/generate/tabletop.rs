//! The family of clear things on a table, seen from close by: for training beside the rooms.

use std::f64::consts::{PI, TAU};

use glam::DVec2;

use super::layout::Layout;
use super::{Level, Physics, Random};
use crate::sim::material::{Material, Pattern};
use crate::sim::scene::{Block, Cylinder, Pane, Room, Scene};

/// Sides of a clear vessel: panes are flat.
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
    let clear = Material {
        reflectance: layout.random.within(0.03, 0.08),
        transmission: layout.random.within(0.80, 0.97),
        ..Material::glass()
    };
    layout.scene.materials.insert("clear".into(), clear);
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
    let (clear, dishes) = (layout.random.count(3, 6), layout.random.count(0, 3));
    for thing in 0..clear + dishes {
        let radius_m = layout.random.within(0.025, 0.07);
        let at = DVec2::new(
            layout.random.within(-0.7, 0.5) * table.half_m[0],
            layout.random.within(-0.8, 0.8) * table.half_m[1],
        );
        if taken.iter().any(|&(other, radius)| at.distance(other) < radius + radius_m + 0.01) {
            continue;
        }
        taken.push((at, radius_m));
        let height_m = layout.random.within(0.04, 0.18);
        if thing < clear {
            let yaw_rad = layout.random.within(0.0, TAU);
            vessel(&mut layout.scene, at.extend(table.height_m).to_array(), radius_m, height_m, yaw_rad);
        } else {
            let base_m = [at.x, at.y, table.height_m];
            let dish = Cylinder { base_m, radius_m, height_m: 0.6 * height_m, material: "dish".into() };
            layout.scene.cylinders.push(dish);
        }
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
