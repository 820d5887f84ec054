//! The family of glass: rooms and corridors with glass fronts, partitions, railings, doors, mirrors.

use std::f64::consts::FRAC_PI_2;

use super::layout::Layout;
use super::{Level, Physics, Random, train};
use crate::sim::material::Material;
use crate::sim::scene::{Block, Pane, Room, Scene};

/// Width of the posts between panes, metres.
const POST_M: f64 = 0.06;

pub(super) fn scene(level: Level, random: &mut Random) -> Scene {
    let physics = Physics::drawn(level, random);
    let (width, depth, behind) = (random.within(7.0, 11.0), random.within(5.0, 7.0), random.within(3.0, 5.0));
    let room = |min_m, max_m| Room { min_m, max_m, walls: "walls".into() };
    let rooms = vec![room([0.0, 0.0], [width, depth]), room([0.0, depth], [width, depth + behind])];
    let mut layout = Layout::new(rooms, physics, random);
    train::materials(&mut layout);
    let glow = layout.random.within(5.0, 9.0);
    layout.lamps(3.2, [0.6, 0.6], [glow, glow * 0.95, glow * 0.85]);
    if layout.random.chance(0.4) {
        // Coated against heat: it reflects more of the infrared than of the light.
        let coated = Material {
            reflectance: layout.random.within(0.08, 0.2),
            transmission: layout.random.within(0.5, 0.8),
            ..Material::glass()
        };
        layout.scene.materials.insert("glass".into(), coated);
    }
    front(&mut layout, width, depth);
    railing(&mut layout, width, depth);
    if layout.random.chance(0.6) {
        let width_m = layout.random.within(0.8, 1.0);
        layout.glass_pane(width_m, 2.1);
    }
    if layout.random.chance(0.5) {
        let width_m = layout.random.within(0.6, 2.0);
        layout.hang(width_m, 1.8, 1.0, "mirror");
    }
    train::furnish(&mut layout);
    layout.scene
}

/// The whole side of the room: panes from floor to ceiling, or windows above a sill, between posts; at times with an
/// open door.
pub(super) fn front(layout: &mut Layout<'_>, width: f64, at_y: f64) {
    let panes = layout.random.count(4, 7);
    let step = width / f64::from(panes);
    let sill_m = if layout.random.chance(0.3) { layout.random.within(0.3, 0.9) } else { 0.0 };
    let door = layout.random.chance(0.5).then(|| layout.random.count(0, panes - 1));
    let ceiling_m = layout.scene.ceiling_m;
    let height_m = ceiling_m - sill_m;
    for number in 0..panes {
        let x = (f64::from(number) + 0.5) * step;
        let post = Block {
            center_m: [x - step / 2.0, at_y, ceiling_m / 2.0],
            size_m: [POST_M, POST_M, ceiling_m],
            yaw_rad: 0.0,
            material: "metal".into(),
        };
        layout.scene.boxes.push(post);
        if door == Some(number) && step > 1.2 {
            continue;
        }
        layout.scene.panes.push(Pane {
            center_m: [x, at_y, sill_m + height_m / 2.0],
            width_m: step - POST_M,
            height_m,
            yaw_rad: FRAC_PI_2,
            material: "glass".into(),
        });
        if sill_m > 0.0 {
            layout.scene.boxes.push(Block {
                center_m: [x, at_y, sill_m / 2.0],
                size_m: [step - POST_M, 0.08, sill_m],
                yaw_rad: 0.0,
                material: "paint".into(),
            });
        }
    }
}

/// A glass railing of a metre's height across a part of the room.
fn railing(layout: &mut Layout<'_>, width: f64, depth: f64) {
    if !layout.random.chance(0.6) {
        return;
    }
    let (length, height_m) = (layout.random.within(1.5, 3.0), layout.random.within(0.9, 1.1));
    let (x, y) = (layout.random.within(0.25, 0.6) * width, layout.random.within(0.35, 0.65) * depth);
    let mut part = 0.0;
    while part < length {
        layout.scene.panes.push(Pane {
            center_m: [x + part + 0.5, y, height_m / 2.0],
            width_m: 0.98,
            height_m,
            yaw_rad: FRAC_PI_2,
            material: "glass".into(),
        });
        part += 1.0;
    }
}
