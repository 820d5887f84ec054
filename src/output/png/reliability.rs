//! Reliability over the camera's image: what is trusted stays as it is, the rest turns red or dark.
//! Depth takes the place of colour where there is none.

use crate::map::{FrameImages, Update};
use crate::output::png::canvas::{Canvas, Rgb, TEXT_HEIGHT, byte, mix};
use crate::output::png::{MARGIN, legend_entry, status_line, with_panel};

/// Width that small images are scaled up to, enough for the legend, pixels.
const TARGET_WIDTH: u32 = 640;
/// Height that they are not scaled beyond, pixels.
const MAX_HEIGHT: u32 = 1280;
const UNRELIABLE: Rgb = [255, 32, 16];
/// Share of red in a pixel at or under tau.
const TINT: f32 = 0.68;
/// What is left of the image's brightness where there is no depth.
const HOLE_BRIGHTNESS: f32 = 0.22;
const HATCH: Rgb = [74, 78, 92];
const HATCH_SPACING: i64 = 8;
/// What registered colour is where the colour camera does not see the depth camera's pixel.
const UNSEEN: Rgb = [0; 3];
/// Depths drawn lightest and darkest where there is no colour, metres.
const GREY_NEAR_M: f32 = 0.3;
const GREY_FAR_M: f32 = 10.0;

/// `None` where a buffer does not fill the image.
pub(super) fn draw(images: &FrameImages, update: &Update, tau: f32) -> Option<Canvas> {
    let pixels = images.width as usize * images.height as usize;
    let color_fits = images.color.as_ref().is_none_or(|rgb| rgb.len() == 3 * pixels);
    if pixels == 0 || images.depth_m.len() != pixels || images.reliability.len() != pixels || !color_fits {
        return None;
    }
    let scale = TARGET_WIDTH.div_ceil(images.width).min(MAX_HEIGHT / images.height).max(1);
    let (width, height) = (images.width * scale, images.height * scale);
    let mut canvas = with_panel(width, height, TARGET_WIDTH);
    for y in 0..height {
        for x in 0..width {
            let pixel = (y / scale * images.width + x / scale) as usize;
            let color = overlay(images, pixel, tau, hatched(x.into(), y.into()));
            canvas.set(x.into(), y.into(), color);
        }
    }
    draw_legend(&mut canvas, i64::from(height) + MARGIN);
    status_line(&mut canvas, i64::from(height) + 2 * MARGIN + TEXT_HEIGHT, update);
    Some(canvas)
}

fn overlay(images: &FrameImages, pixel: usize, tau: f32, hatched: bool) -> Rgb {
    let depth_m = images.depth_m[pixel];
    // Written so that NaN counts as no depth.
    let measured = depth_m > 0.0;
    let rgb = images.color.as_ref().map(|rgb| [rgb[3 * pixel], rgb[3 * pixel + 1], rgb[3 * pixel + 2]]);
    let color = rgb.filter(|&rgb| !(measured && rgb == UNSEEN)).unwrap_or_else(|| grey_of_depth(depth_m));
    match (measured, hatched) {
        (false, true) => HATCH,
        (false, false) => mix([0; 3], color, HOLE_BRIGHTNESS),
        (true, _) => mix(color, UNRELIABLE, tint(images.reliability[pixel], tau)),
    }
}

/// Share of red: full up to tau, then falling to nothing at reliability 1.
fn tint(reliability: f32, tau: f32) -> f32 {
    let doubt = (1.0 - reliability) / (1.0 - tau).max(f32::EPSILON);
    // A NaN reliability is no reliability.
    if doubt.is_nan() { TINT } else { TINT * doubt.clamp(0.0, 1.0).powi(2) }
}

fn hatched(x: i64, y: i64) -> bool {
    (x + y) % HATCH_SPACING < 2
}

/// Light near, dark far, by the logarithm of depth.
fn grey_of_depth(depth_m: f32) -> Rgb {
    let share = (depth_m / GREY_NEAR_M).ln() / (GREY_FAR_M / GREY_NEAR_M).ln();
    [byte(235.0 - 195.0 * share.clamp(0.0, 1.0)); 3]
}

fn draw_legend(canvas: &mut Canvas, y: i64) {
    let trusted = [140; 3];
    let mut x = legend_entry(canvas, MARGIN, y, "reliable", trusted);
    x = legend_entry(canvas, x, y, "unreliable", mix(trusted, UNRELIABLE, TINT));
    let hole_x = x + 1;
    legend_entry(canvas, x, y, "no depth", mix([0; 3], trusted, HOLE_BRIGHTNESS));
    for row in 0..TEXT_HEIGHT {
        for column in (0..TEXT_HEIGHT).filter(|column| hatched(*column, row)) {
            canvas.set(hole_x + column, y + row, HATCH);
        }
    }
}
