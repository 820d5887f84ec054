//! The map by the classes of its cells, north up.

use glam::DVec2;

use crate::map::rule::BRIDGED_ROW;
use crate::map::{CellClass, MapUpdate, Update, Verdict};
use crate::output::png::canvas::{Canvas, Rgb, mix};
use crate::output::png::costmap::{draw_robot, draw_scale_bar};
use crate::output::png::{BLACK, LINE_HEIGHT, MARGIN, legend_entry, status_line, with_panel_of_lines};

/// Side of the picture that the cells are scaled up to, pixels.
const TARGET_SIDE: u32 = 1000;
const LEGEND_WIDTH: u32 = 860;
/// Of a legend that names what verdicts tell apart, in two lines: no wider than most maps, since the ground of what lies beside
/// the map would look free.
const VERDICT_LEGEND_WIDTH: u32 = 640;

const UNKNOWN: Rgb = [82, 88, 92];
const FREE: Rgb = [24, 26, 30];
const SOLID: Rgb = [250, 246, 236];
const PASSABLE: Rgb = [74, 178, 84];
const TRANSPARENT: Rgb = [255, 206, 48];
/// Of the lowest and the highest cost of an inflated cell, and of one within the inscribed radius.
const INFLATED_LOW: Rgb = [44, 52, 88];
const INFLATED_HIGH: Rgb = [72, 112, 214];
const INSCRIBED: Rgb = [164, 92, 216];
/// What verdicts tell apart beside these.
const GLASS: Rgb = [44, 190, 214];
const OCCUPIED: Rgb = [244, 120, 72];
const STALE: Rgb = [122, 92, 70];
const GOAL: Rgb = [64, 224, 255];

/// What classes tell apart.
const LEGEND: [(&str, Rgb); 7] = [
    ("solid", SOLID),
    ("transparent", TRANSPARENT),
    ("passable", PASSABLE),
    ("inscribed", INSCRIBED),
    ("inflated", INFLATED_HIGH),
    ("free", FREE),
    ("unknown", UNKNOWN),
];
/// What verdicts tell apart.
const VERDICT_LEGEND: [(&str, Rgb); 10] = [
    ("glass", GLASS),
    ("solid", SOLID),
    ("transparent", TRANSPARENT),
    ("occupied", OCCUPIED),
    ("passable", PASSABLE),
    ("inscribed", INSCRIBED),
    ("inflated", INFLATED_HIGH),
    ("free", FREE),
    ("unknown", UNKNOWN),
    ("stale", STALE),
];

/// Length of the arrow towards the goal, pixels.
const GOAL_PIXELS: f64 = 34.0;

/// The costs, the classes and the verdicts, where there are any, must fill the grid.
pub(super) fn draw(update: &Update, map: &MapUpdate) -> Canvas {
    let grid = &map.grid;
    let scale = (TARGET_SIDE / grid.width.max(grid.height)).max(1);
    let (width, height) = (grid.width * scale, grid.height * scale);
    let by_verdict = !map.verdicts.is_empty();
    let (lines, legend_width) = if by_verdict { (2, VERDICT_LEGEND_WIDTH) } else { (1, LEGEND_WIDTH) };
    let mut canvas = with_panel_of_lines(width, height, legend_width, lines);
    draw_cells(&mut canvas, map, i64::from(scale));
    draw_robot(&mut canvas, grid, update.map_from_base, f64::from(scale));
    if let Some(goal) = map.towards_goal {
        draw_goal(&mut canvas, update, map, goal, f64::from(scale));
    }
    draw_scale_bar(&mut canvas, i64::from(height), f64::from(scale) / grid.resolution_m);
    let line = |number: u32| i64::from(height) + MARGIN + i64::from(LINE_HEIGHT * number);
    if by_verdict {
        draw_legend(&mut canvas, line(0), &VERDICT_LEGEND[..5]);
        draw_legend(&mut canvas, line(1), &VERDICT_LEGEND[5..]);
    } else {
        draw_legend(&mut canvas, line(0), &LEGEND);
    }
    status_line(&mut canvas, line(lines), update);
    canvas
}

fn draw_cells(canvas: &mut Canvas, map: &MapUpdate, scale: i64) {
    let width = map.grid.width as usize;
    let color = |cell: usize| {
        let (class, cost) = (map.classes[cell], map.costmap[cell]);
        let verdict = map.verdicts.get(cell).and_then(|verdict| color_of_verdict(class, *verdict));
        verdict.unwrap_or_else(|| color_of(class, cost))
    };
    let rows = (0..map.grid.height as usize).rev();
    for (y, row) in (0..).zip(rows) {
        for (x, cell) in (0..).zip(row * width..(row + 1) * width) {
            canvas.fill(x * scale, y * scale, scale, scale, color(cell));
        }
    }
}

/// Colour of what the class does not tell apart (rows of spec 4 §2); `None`: that of the class.
fn color_of_verdict(class: u8, verdict: Verdict) -> Option<Rgb> {
    let inflated = class == CellClass::Inflated as u8;
    match verdict.row() {
        1 => Some(GLASS),
        2 => Some(SOLID),
        3 => Some(TRANSPARENT),
        4 | 6 | BRIDGED_ROW if verdict.cost() == 254 => Some(OCCUPIED),
        11 if !inflated => Some(STALE),
        _ => None,
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
fn draw_goal(canvas: &mut Canvas, update: &Update, map: &MapUpdate, goal: DVec2, scale: f64) {
    let grid = &map.grid;
    let pixels_per_m = scale / grid.resolution_m;
    let base = update.map_from_base.translation_m;
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

fn draw_legend(canvas: &mut Canvas, y: i64, entries: &[(&str, Rgb)]) {
    let mut x = MARGIN;
    for (label, color) in entries {
        x = legend_entry(canvas, x, y, label, *color) - 4;
    }
}
