//! The family of glass with something right behind it: shop windows, aquaria, counters with bottles; steel fronts,
//! black gloss, foil, and sun patches. For training beside the rooms.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec2;

use super::layout::Layout;
use super::{Level, Physics, Random, shiny, train, vessels};
use crate::sim::footprint::Shape;
use crate::sim::scene::{Block, Cylinder, Pane, Room, Scene};
use crate::sim::sun::Sun;

pub(super) fn scene(level: Level, frames: u32, random: &mut Random) -> Scene {
    let physics = Physics::drawn(level, random);
    let (width, depth) = (random.within(4.5, 7.0), random.within(4.0, 6.0));
    let (min_m, max_m) = ([-width / 2.0, -depth / 2.0], [width / 2.0, depth / 2.0]);
    let mut layout = Layout::new(vec![Room { min_m, max_m, walls: "walls".into() }], physics, random);
    train::materials(&mut layout);
    shiny::materials(&mut layout);
    vessels::materials(&mut layout);
    let glow = layout.random.within(5.0, 9.0);
    layout.lamps(3.2, [0.6, 0.6], [glow, glow * 0.95, glow * 0.85]);
    if physics.window_infrared > 0.0 {
        sunny_window(&mut layout);
    }
    let mut things = Vec::new();
    for build in [shop_window, aquarium, counter, shop_window, aquarium, counter] {
        things.extend(build(&mut layout));
    }
    fronts(&mut layout);
    if layout.random.chance(0.5) {
        let (width_m, height_m) = (layout.random.within(0.6, 1.6), layout.random.within(0.4, 1.0));
        layout.hang(width_m, height_m, 1.1, "black");
    }
    for _ in 0..layout.random.count(0, 2) {
        train::crate_box(&mut layout);
    }
    // Half of the robots look level, from higher up.
    if layout.random.chance(0.5) {
        layout.scene.camera.height_m = layout.random.within(0.5, 1.2);
        layout.scene.camera.pitch_rad = layout.random.within(0.0, 0.3);
    }
    if !things.is_empty() {
        let thing = layout.random.pick(&things);
        drive_up(&mut layout, thing, frames);
    }
    layout.scene
}

/// The robot drives up to one of the things, a little off its middle.
fn drive_up(layout: &mut Layout<'_>, (at, facing): (DVec2, f64), frames: u32) {
    let length_m = f64::from(frames) * layout.scene.trajectory.step_m;
    let end =
        at + DVec2::from_angle(facing + layout.random.within(-0.5, 0.5)) * layout.random.within(0.85, 1.7);
    let look = (at - end).rotate(DVec2::from_angle(layout.random.within(-0.2, 0.2)));
    let start = end - look.normalize() * length_m;
    layout.scene.trajectory.waypoints_m = vec![start.to_array(), end.to_array()];
}

/// A window, through which the sun shines most of the time.
fn sunny_window(layout: &mut Layout<'_>) {
    let daylight = layout.random.within(4.0, 12.0);
    let side = layout.physics.window_m;
    layout.window(side, side * 0.85, 1.45, [daylight, daylight, daylight * 1.1]);
    let Some(window) = layout.scene.windows.first() else { return };
    let (yaw_rad, infrared) = (window.yaw_rad, window.infrared);
    if layout.random.chance(0.75) {
        let strength = layout.random.within(0.3, 2.0);
        let white = daylight * strength;
        layout.scene.sun = Some(Sun {
            yaw_rad: yaw_rad + PI + layout.random.within(-0.9, 0.9),
            elevation_rad: layout.random.within(0.25, 0.9),
            color: [white * 1.1, white, white * 0.85],
            infrared: infrared * strength,
        });
    }
}

/// A place by a wall for something of that size: its middle, its yaw and its outline.
fn by_a_wall(layout: &mut Layout<'_>, [width, depth]: [f64; 2]) -> Option<(DVec2, f64, Shape)> {
    let (wall, facing) = layout.on_a_wall(width)?;
    let at = wall + DVec2::from_angle(facing) * (depth / 2.0 + 0.02);
    let yaw_rad = facing - FRAC_PI_2;
    let half = DVec2::new(width, depth) / 2.0 - 0.01;
    Some((at, yaw_rad, Shape::Rectangle(at, half, DVec2::from_angle(yaw_rad))))
}

/// Boxes of goods side by side in a row of that length, from `bottom_m` up, at most `most_m` high.
fn row_of_goods(
    layout: &mut Layout<'_>,
    middle: DVec2,
    yaw_rad: f64,
    length: f64,
    span_m: [f64; 2],
) -> Vec<Block> {
    let along = DVec2::from_angle(yaw_rad);
    let [bottom_m, most_m] = span_m;
    let (mut boxes, mut gone) = (Vec::new(), 0.0);
    while gone < length - 0.08 && boxes.len() < 6 {
        let width = layout.random.within(0.08, 0.5).min(length - gone);
        let height = layout.random.within(0.3, 1.0) * most_m;
        let at = middle + along * (gone + width / 2.0 - length / 2.0);
        boxes.push(Block {
            center_m: [at.x, at.y, bottom_m + height / 2.0],
            size_m: [width * 0.9, layout.random.within(0.05, 0.12), height],
            yaw_rad,
            material: layout.random.pick(&["goods", "label", "picture", "foil", "wood", "paint"]).into(),
        });
        gone += width;
    }
    boxes
}

/// Where a thing stands, and the direction that it faces.
type Stand = Option<(DVec2, f64)>;

/// A glass front before a wall, with goods on a ledge close behind it.
fn shop_window(layout: &mut Layout<'_>) -> Stand {
    let (width, depth) = (layout.random.within(1.0, 2.4), layout.random.within(0.25, 0.6));
    let (at, yaw_rad, outline) = by_a_wall(layout, [width, depth])?;
    let front = DVec2::from_angle(yaw_rad).perp() * depth / 2.0;
    let ledge_m = layout.random.within(0.05, 0.5);
    let ledge = Block {
        center_m: [at.x, at.y, ledge_m / 2.0],
        size_m: [width, depth - 0.02, ledge_m],
        yaw_rad,
        material: layout.random.pick(&["paint", "wood", "black", "steel"]).into(),
    };
    let row = at + front * layout.random.within(-0.6, 0.6);
    let mut boxes = row_of_goods(layout, row, yaw_rad, width - 0.06, [ledge_m, 0.9]);
    boxes.push(ledge);
    let top_m = ledge_m + layout.random.within(1.1, 1.6);
    if !layout.place(outline, 0.004, boxes) {
        return None;
    }
    let pane = at + front * 0.99;
    let facing = yaw_rad + FRAC_PI_2;
    layout.scene.panes.push(Pane {
        center_m: [pane.x, pane.y, (ledge_m + top_m) / 2.0],
        width_m: width,
        height_m: top_m - ledge_m,
        yaw_rad: facing,
        material: "glass".into(),
    });
    Some((pane, facing))
}

/// A tank of water on a stand, with gravel and things in it.
fn aquarium(layout: &mut Layout<'_>) -> Stand {
    let (width, depth) = (layout.random.within(0.5, 1.4), layout.random.within(0.3, 0.5));
    let (at, yaw_rad, outline) = by_a_wall(layout, [width, depth])?;
    let (stand_m, tall_m) = (layout.random.within(0.05, 0.5), layout.random.within(0.3, 0.6));
    let block = |height_m: f64, bottom_m: f64, inset_m: f64, material: &str| Block {
        center_m: [at.x, at.y, bottom_m + height_m / 2.0],
        size_m: [width - inset_m, depth - inset_m, height_m],
        yaw_rad,
        material: material.into(),
    };
    let stand = layout.random.pick(&["wood", "paint", "black", "steel"]);
    let mut boxes = vec![
        block(stand_m, 0.0, 0.02, stand),
        block(tall_m, stand_m, 0.0, "water"),
        block(0.05, stand_m + 0.002, 0.01, "fabric"),
    ];
    let row = at + DVec2::from_angle(yaw_rad).perp() * depth * layout.random.within(-0.3, 0.2);
    boxes.extend(row_of_goods(layout, row, yaw_rad, width - 0.1, [stand_m + 0.01, tall_m - 0.05]));
    layout.place(outline, 0.004, boxes).then_some((at, yaw_rad + FRAC_PI_2))
}

/// A low counter with bottles, glasses and foil on it.
fn counter(layout: &mut Layout<'_>) -> Stand {
    let (width, depth, height) =
        (layout.random.within(0.6, 1.4), layout.random.within(0.35, 0.5), layout.random.within(0.25, 0.55));
    let (at, yaw_rad, outline) = by_a_wall(layout, [width, depth])?;
    let material = layout.random.pick(&["wood", "black", "steel", "paint"]).into();
    let size_m = [width, depth, height];
    let body = Block { center_m: [at.x, at.y, height / 2.0], size_m, yaw_rad, material };
    if !layout.place(outline, 0.004, vec![body]) {
        return None;
    }
    let (along, aside) = (DVec2::from_angle(yaw_rad), DVec2::from_angle(yaw_rad).perp());
    let mut gone = 0.1;
    while gone < width - 0.1 {
        let radius_m = layout.random.within(0.03, 0.08);
        let place = at + along * (gone - width / 2.0) + aside * depth * layout.random.within(-0.25, 0.25);
        let base_m = place.extend(height).to_array();
        let height_m = layout.random.within(0.08, 0.32);
        if layout.random.chance(0.75) {
            vessels::put(layout, base_m, radius_m, height_m);
        } else {
            let material = layout.random.pick(&["foil", "label", "steel"]).into();
            layout.scene.cylinders.push(Cylinder { base_m, radius_m, height_m, material });
        }
        gone += layout.random.within(0.17, 0.3);
    }
    Some((at, yaw_rad + FRAC_PI_2))
}

/// A fridge of steel and a cupboard of black gloss.
fn fronts(layout: &mut Layout<'_>) {
    for material in ["steel", "black", "foil"] {
        let (width, depth) = (layout.random.within(0.5, 0.9), layout.random.within(0.4, 0.65));
        let height = layout.random.within(0.5, 1.9);
        if !layout.random.chance(0.6) {
            continue;
        }
        if let Some((at, yaw_rad, outline)) = by_a_wall(layout, [width, depth]) {
            let (center_m, size_m) = ([at.x, at.y, height / 2.0], [width, depth, height]);
            layout.place(
                outline,
                0.004,
                vec![Block { center_m, size_m, yaw_rad, material: material.into() }],
            );
        }
    }
}
