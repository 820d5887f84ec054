//! The costmap as RViz's costmap colour scheme shows it, north up.

use crate::base::Rigid;
use crate::map::{Grid, MapUpdate, Update};
use crate::output::occupancy_of_cost;
use crate::output::png::canvas::{Canvas, Rgb, TEXT_HEIGHT, byte, mix};
use crate::output::png::{BLACK, MARGIN, WHITE, legend_entry, status_line, with_panel};
use glam::DVec3;

/// Side of the picture that the cells are scaled up to, pixels.
const TARGET_SIDE: u32 = 720;
const LEGEND_WIDTH: u32 = 680;
/// RViz draws free cells transparent; this is its default background.
const FREE: Rgb = [48, 48, 48];
const INSCRIBED: Rgb = [0, 255, 255];
const LETHAL: Rgb = [255, 0, 255];
const UNKNOWN: Rgb = [0x70, 0x89, 0x86];

/// Half the length of the robot's arrow: metres, and pixels at least.
const ARROW_HALF_M: f64 = 0.22;
const ARROW_HALF_MIN_PIXELS: f64 = 9.0;

/// The costmap must fill the grid.
pub(super) fn draw(update: &Update, map: &MapUpdate) -> Canvas {
    let grid = &map.grid;
    let scale = (TARGET_SIDE / grid.width.max(grid.height)).max(1);
    let (width, height) = (grid.width * scale, grid.height * scale);
    let mut canvas = with_panel(width, height, LEGEND_WIDTH);
    draw_cells(&mut canvas, grid, &map.costmap, i64::from(scale));
    draw_robot(&mut canvas, grid, update.map_from_base, f64::from(scale));
    draw_scale_bar(&mut canvas, i64::from(height), f64::from(scale) / grid.resolution_m);
    draw_legend(&mut canvas, i64::from(height) + MARGIN);
    status_line(&mut canvas, i64::from(height) + 2 * MARGIN + TEXT_HEIGHT, update);
    canvas
}

/// A costmap without the robot.
///
/// # Errors
/// [`crate::Error::File`]; [`crate::Error::Encode`] where the costs do not fill the grid.
#[cfg(feature = "ros2")]
pub(crate) fn save_costs(path: &std::path::Path, grid: &Grid, costs: &[u8]) -> crate::Result<()> {
    if costs.is_empty() || costs.len() != grid.width as usize * grid.height as usize {
        let reason = format!("{} costs do not fill {}x{} cells", costs.len(), grid.width, grid.height);
        return Err(crate::output::encode_error(path, reason));
    }
    let scale = (TARGET_SIDE / grid.width.max(grid.height)).max(1);
    let (width, height) = (grid.width * scale, grid.height * scale);
    let mut canvas = with_panel(width, height, LEGEND_WIDTH);
    draw_cells(&mut canvas, grid, costs, i64::from(scale));
    draw_scale_bar(&mut canvas, i64::from(height), f64::from(scale) / grid.resolution_m);
    draw_legend(&mut canvas, i64::from(height) + MARGIN);
    canvas.save(path)
}

fn draw_cells(canvas: &mut Canvas, grid: &Grid, costmap: &[u8], scale: i64) {
    let rows = costmap.chunks_exact(grid.width as usize).rev();
    for (y, row) in (0..).zip(rows) {
        for (x, &cost) in (0..).zip(row) {
            canvas.fill(x * scale, y * scale, scale, scale, color_of_cost(cost));
        }
    }
}

/// RViz's palette: blue to red for occupancies 1..=98.
pub(crate) fn color_of_cost(cost: u8) -> Rgb {
    match occupancy_of_cost(cost) {
        0 => FREE,
        99 => INSCRIBED,
        100 => LETHAL,
        -1 => UNKNOWN,
        graded => graded_color(f32::from(graded) / 100.0),
    }
}

fn graded_color(share: f32) -> Rgb {
    let red = byte(255.0 * share);
    [red, 0, 255 - red]
}

/// An arrow at the robot's base that points along its x axis.
pub(super) fn draw_robot(canvas: &mut Canvas, grid: &Grid, base: Rigid, scale: f64) {
    let heading = base.rotation * DVec3::X;
    let length = heading.truncate().length();
    if length < 1e-6 || length.is_nan() {
        return;
    }
    let forward = heading.truncate() / length;
    let pixels_per_m = scale / grid.resolution_m;
    let x = (base.translation_m.x - grid.origin_x_m) * pixels_per_m;
    let y = f64::from(grid.height) * scale - (base.translation_m.y - grid.origin_y_m) * pixels_per_m;
    let half = (ARROW_HALF_M * pixels_per_m).max(ARROW_HALF_MIN_PIXELS);
    // Picture rows run against the map's y.
    let at = |ahead: f64, left: f64| {
        [x + half * (forward.x * ahead - forward.y * left), y - half * (forward.y * ahead + forward.x * left)]
    };
    let rim = 1.0 + 4.0 / half;
    canvas.triangle([at(rim * 1.1, 0.0), at(-rim, rim * 0.85), at(-rim, -rim * 0.85)], BLACK);
    canvas.triangle([at(1.0, 0.0), at(-0.85, 0.65), at(-0.85, -0.65)], WHITE);
}

pub(super) fn draw_scale_bar(canvas: &mut Canvas, map_height: i64, pixels_per_m: f64) {
    #[expect(clippy::cast_possible_truncation, reason = "a metre in pixels; casts saturate")]
    let length = pixels_per_m.round().min(1e4) as i64;
    let y = map_height - MARGIN - 4;
    canvas.fill_framed(MARGIN, y, length, 4, WHITE, BLACK);
    canvas.rimmed_text(MARGIN, y - TEXT_HEIGHT - 6, "1 m", WHITE, BLACK);
}

fn draw_legend(canvas: &mut Canvas, y: i64) {
    let mut x = legend_entry(canvas, MARGIN, y, "free", FREE);
    x = legend_ramp(canvas, x, y);
    for (label, color) in [("inscribed", INSCRIBED), ("lethal", LETHAL), ("unknown", UNKNOWN)] {
        x = legend_entry(canvas, x, y, label, color);
    }
}

fn legend_ramp(canvas: &mut Canvas, x: i64, y: i64) -> i64 {
    const STEPS: u8 = 60;
    let (low, high) = (color_of_cost(1), color_of_cost(252));
    for step in 0..STEPS {
        let color = mix(low, high, f32::from(step) / f32::from(STEPS - 1));
        canvas.fill(x + 1 + i64::from(step), y - 1, 1, TEXT_HEIGHT + 2, color);
    }
    canvas.text(x + i64::from(STEPS) + 10, y, "cost 1-252", crate::output::png::TEXT) + MARGIN
}
