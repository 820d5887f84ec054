//! A labelled scan from above, in the lidar's frame: x up, y to the left.

use glam::DVec3;

use super::canvas::{Canvas, Rgb, TEXT_HEIGHT};
use super::costmap::draw_scale_bar;
use super::{MARGIN, TEXT, legend_entry, with_panel};
use crate::glass::{LabelledScan, PointClass, cleaned};
use crate::lidar::ScanOutput;
use crate::recording::points::Scan;

/// Side of the picture, pixels.
const SIDE: u32 = 900;
const LEGEND_WIDTH: u32 = 900;
/// Share of the points that the picture shows at least; the farthest may lie outside.
const SHOWN_SHARE: f64 = 0.995;
/// Steps along a pane.
const PANE_STEPS: u32 = 1000;

const GROUND: Rgb = [16, 17, 20];
const MIRRORED: Rgb = [255, 92, 200];
const PANE: Rgb = [120, 255, 240];

fn color_of(class: PointClass) -> Rgb {
    match class {
        PointClass::Inside => [150, 152, 156],
        PointClass::Glass => [44, 190, 214],
        PointClass::Reflection => [150, 34, 34],
        PointClass::Outside => [255, 166, 32],
        PointClass::Unlabelled => [84, 74, 120],
    }
}

/// The scan's points in the colours of their classes, reflections both where they were measured and where they come from.
pub(super) fn draw(scan: &Scan, labelled: &LabelledScan, output: &ScanOutput) -> Canvas {
    let mut canvas = with_panel(SIDE, SIDE, LEGEND_WIDTH);
    let side = i64::from(SIDE);
    canvas.fill(0, 0, side, side, GROUND);
    let pixels_per_m = 0.5 * f64::from(SIDE) / reach_m(scan);
    let mut dot = |place_m: DVec3, color: Rgb, size: i64| {
        let at = |metres: f64| {
            #[expect(clippy::cast_possible_truncation, reason = "saturates, and lies outside the picture then")]
            let pixel = (0.5 * f64::from(SIDE) - metres * pixels_per_m) as i64;
            pixel
        };
        let (x, y) = (at(place_m.y), at(place_m.x));
        if (0..side - size).contains(&x) && (0..side - size).contains(&y) {
            canvas.fill(x, y, size, size, color);
        }
    };
    let order = [PointClass::Unlabelled, PointClass::Reflection, PointClass::Inside, PointClass::Outside, PointClass::Glass];
    for wanted in order {
        let points = scan.points.iter().zip(&labelled.classes).filter(|(_, (class, _))| *class == wanted);
        for (point, _) in points {
            dot(DVec3::from(point.position_m().map(f64::from)), color_of(wanted), 2);
        }
    }
    for point in cleaned(scan, labelled).filter(|point| point.class == PointClass::Reflection) {
        dot(point.place_m, MIRRORED, 2);
    }
    for pane in &labelled.panes {
        let [a, b, ..] = pane.corners_m();
        for step in 0..=PANE_STEPS {
            dot(a.lerp(b, f64::from(step) / f64::from(PANE_STEPS)), PANE, 2);
        }
    }
    draw_scale_bar(&mut canvas, side, pixels_per_m);
    draw_legend(&mut canvas, side + MARGIN);
    let [_, inside, glass, reflections, outside] = labelled.counters.classes;
    let status = format!(
        "{:06}  {inside} inside  {glass} glass  {reflections} reflections  {outside} outside  {} panes",
        output.index,
        labelled.panes.len()
    );
    canvas.text(MARGIN, side + 2 * MARGIN + TEXT_HEIGHT, &status, TEXT);
    canvas
}

/// Distance from the lidar that the picture shows, metres.
fn reach_m(scan: &Scan) -> f64 {
    let mut ways: Vec<f64> =
        scan.points.iter().map(|p| f64::from(p.x_m.abs().max(p.y_m.abs()))).filter(|w| w.is_finite()).collect();
    ways.sort_by(f64::total_cmp);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "an index into the points"
    )]
    let at = (SHOWN_SHARE * ways.len().saturating_sub(1) as f64) as usize;
    ways.get(at).map_or(1.0, |way| way.max(1.0))
}

fn draw_legend(canvas: &mut Canvas, y: i64) {
    let mut x = MARGIN;
    for class in [PointClass::Inside, PointClass::Glass, PointClass::Reflection, PointClass::Outside, PointClass::Unlabelled] {
        x = legend_entry(canvas, x, y, class.name(), color_of(class)) - 4;
    }
    x = legend_entry(canvas, x, y, "mirrored", MIRRORED) - 4;
    legend_entry(canvas, x, y, "pane", PANE);
}
