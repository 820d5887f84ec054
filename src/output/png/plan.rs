//! The plan map of a lidar scan in its own colours by class, north up.

use glam::DVec2;

use crate::lidar::{CellClass, ScanOutput};
use crate::output::png::canvas::{Canvas, Rgb, TEXT_HEIGHT, mix};
use crate::output::png::costmap::{draw_robot, draw_scale_bar};
use crate::output::png::{BLACK, MARGIN, TEXT, legend_entry, with_panel};

/// Side of the picture that the cells are scaled up to, pixels.
const TARGET_SIDE: u32 = 1000;
const LEGEND_WIDTH: u32 = 860;

const UNKNOWN: Rgb = [82, 88, 92];
const FREE: Rgb = [24, 26, 30];
const SOLID: Rgb = [250, 246, 236];
const PASSABLE: Rgb = [74, 178, 84];
const TRANSPARENT: Rgb = [255, 206, 48];
/// Of the lowest and the highest cost of an inflated cell, and of one within the inscribed radius.
const INFLATED_LOW: Rgb = [44, 52, 88];
const INFLATED_HIGH: Rgb = [72, 112, 214];
const INSCRIBED: Rgb = [164, 92, 216];
const GOAL: Rgb = [64, 224, 255];

/// Length of the arrow towards the goal, pixels.
const GOAL_PIXELS: f64 = 34.0;

/// The costs and classes must fill the grid.
pub(super) fn draw(output: &ScanOutput) -> Canvas {
    let grid = &output.grid;
    let scale = (TARGET_SIDE / grid.width.max(grid.height)).max(1);
    let (width, height) = (grid.width * scale, grid.height * scale);
    let mut canvas = with_panel(width, height, LEGEND_WIDTH);
    draw_cells(&mut canvas, output, i64::from(scale));
    draw_robot(&mut canvas, grid, output.map_from_base, f64::from(scale));
    if let Some(goal) = output.towards_goal {
        draw_goal(&mut canvas, output, goal, f64::from(scale));
    }
    draw_scale_bar(&mut canvas, i64::from(height), f64::from(scale) / grid.resolution_m);
    draw_legend(&mut canvas, i64::from(height) + MARGIN);
    let (seconds, milliseconds) = (output.stamp_ns / 1_000_000_000, output.stamp_ns / 1_000_000 % 1000);
    let status = format!("{:06}  {seconds}.{milliseconds:03} s  {} points", output.index, output.points);
    canvas.text(MARGIN, i64::from(height) + 2 * MARGIN + TEXT_HEIGHT, &status, TEXT);
    canvas
}

fn draw_cells(canvas: &mut Canvas, output: &ScanOutput, scale: i64) {
    let width = output.grid.width as usize;
    let rows = output.classes.chunks_exact(width).zip(output.costmap.chunks_exact(width)).rev();
    for (y, (classes, costs)) in (0..).zip(rows) {
        for (x, (&class, &cost)) in (0..).zip(classes.iter().zip(costs)) {
            canvas.fill(x * scale, y * scale, scale, scale, color_of(class, cost));
        }
    }
}

fn color_of(class: u8, cost: u8) -> Rgb {
    match CellClass::ALL.get(usize::from(class)) {
        Some(CellClass::Free) => FREE,
        Some(CellClass::Solid) => SOLID,
        Some(CellClass::Passable) => PASSABLE,
        Some(CellClass::Transparent) => TRANSPARENT,
        Some(CellClass::Inflated) if cost >= 253 => INSCRIBED,
        Some(CellClass::Inflated) => mix(INFLATED_LOW, INFLATED_HIGH, f32::from(cost) / 252.0),
        Some(CellClass::Unknown) | None => UNKNOWN,
    }
}

/// An arrow from the robot towards its goal.
fn draw_goal(canvas: &mut Canvas, output: &ScanOutput, goal: DVec2, scale: f64) {
    let grid = &output.grid;
    let pixels_per_m = scale / grid.resolution_m;
    let base = output.map_from_base.translation_m;
    // Picture rows run against the map's y.
    let at = DVec2::new(
        (base.x - grid.origin_x_m) * pixels_per_m,
        f64::from(grid.height) * scale - (base.y - grid.origin_y_m) * pixels_per_m,
    );
    let ahead = DVec2::new(goal.x, -goal.y);
    let corner = |along: f64, across: f64| (at + ahead * along + ahead.perp() * across).to_array();
    for (grow, color) in [(2.0, BLACK), (0.0, GOAL)] {
        let (start, neck, tip) = (16.0 - grow, GOAL_PIXELS, GOAL_PIXELS + 14.0 + 1.5 * grow);
        let half = 2.0 + grow;
        canvas.triangle([corner(start, -half), corner(start, half), corner(neck, half)], color);
        canvas.triangle([corner(start, -half), corner(neck, half), corner(neck, -half)], color);
        canvas.triangle(
            [corner(tip, 0.0), corner(neck - grow, 7.0 + grow), corner(neck - grow, -7.0 - grow)],
            color,
        );
    }
}

fn draw_legend(canvas: &mut Canvas, y: i64) {
    let mut x = MARGIN;
    for (label, color) in [
        ("solid", SOLID),
        ("transparent", TRANSPARENT),
        ("passable", PASSABLE),
        ("inscribed", INSCRIBED),
        ("inflated", INFLATED_HIGH),
        ("free", FREE),
        ("unknown", UNKNOWN),
    ] {
        x = legend_entry(canvas, x, y, label, color) - 4;
    }
}
