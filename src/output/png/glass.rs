//! A labelled scan from above, in the lidar's frame: x up, y to the left.

use glam::DVec3;

use crate::map::clean::cleaned;
use crate::map::glass::{LabelledScan, PointClass};
use crate::output::png::canvas::{Canvas, Rgb, TEXT_HEIGHT};
use crate::output::png::costmap::draw_scale_bar;
use crate::output::png::{MARGIN, TEXT, legend_entry, with_panel};
use crate::sensor::{Point, Scan};

/// Side of the picture, pixels.
const SIDE: u32 = 900;
const LEGEND_WIDTH: u32 = 900;
/// Share of the points that the picture shows at least; the farthest may lie outside.
const SHOWN_SHARE: f64 = 0.995;
/// Steps along a pane.
const PANE_STEPS: u32 = 1000;
/// Side of a point, pixels.
const DOT: i64 = 2;

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
pub(super) fn draw(scan: &Scan, labelled: &LabelledScan, index: u64) -> Canvas {
    let mut canvas = with_panel(SIDE, SIDE, LEGEND_WIDTH);
    let side = i64::from(SIDE);
    canvas.fill(0, 0, side, side, GROUND);
    let pixels_per_m = 0.5 * f64::from(SIDE) / reach_m(scan);
    for (place_m, color) in dots(scan, labelled) {
        dot(&mut canvas, place_m * pixels_per_m, color);
    }
    draw_scale_bar(&mut canvas, side, pixels_per_m);
    draw_legend(&mut canvas, side + MARGIN);
    let [_, inside, glass, reflections, outside] = labelled.counters.classes;
    let status = format!(
        "{index:06}  {inside} inside  {glass} glass  {reflections} reflections  {outside} outside  {} panes",
        labelled.panes.len()
    );
    canvas.text(MARGIN, side + 2 * MARGIN + TEXT_HEIGHT, &status, TEXT);
    canvas
}

/// Places and colours in the order in which they are drawn, those that matter most last.
fn dots(scan: &Scan, labelled: &LabelledScan) -> Vec<(DVec3, Rgb)> {
    const ORDER: [PointClass; 5] = [
        PointClass::Unlabelled,
        PointClass::Reflection,
        PointClass::Inside,
        PointClass::Outside,
        PointClass::Glass,
    ];
    let mut dots = Vec::new();
    for wanted in ORDER {
        let points = scan.points.iter().zip(&labelled.classes).filter(|(_, (class, _))| *class == wanted);
        let place = |point: &Point| DVec3::from(point.position_m().map(f64::from));
        dots.extend(points.map(|(point, _)| (place(point), color_of(wanted))));
    }
    let mirrored = cleaned(scan, labelled).filter(|point| point.class == PointClass::Reflection);
    dots.extend(mirrored.map(|point| (point.place_m, MIRRORED)));
    for pane in &labelled.panes {
        let [a, b, c, d] = pane.corners_m();
        let (start, end) = (a.midpoint(d), b.midpoint(c));
        let share = |step: u32| f64::from(step) / f64::from(PANE_STEPS);
        dots.extend((0..=PANE_STEPS).map(|step| (start.lerp(end, share(step)), PANE)));
    }
    dots
}

/// A dot at a place in pixels from the lidar, x up and y to the left.
fn dot(canvas: &mut Canvas, place: DVec3, color: Rgb) {
    #[expect(clippy::cast_possible_truncation, reason = "saturates, and lies outside the picture then")]
    let [x, y] = [place.y, place.x].map(|way| (0.5 * f64::from(SIDE) - way) as i64);
    let inside = 0..i64::from(SIDE) - DOT;
    if inside.contains(&x) && inside.contains(&y) {
        canvas.fill(x, y, DOT, DOT, color);
    }
}

/// Distance from the lidar that the picture shows, metres.
fn reach_m(scan: &Scan) -> f64 {
    let mut ways: Vec<f64> = scan
        .points
        .iter()
        .map(|p| f64::from(p.x_m.abs().max(p.y_m.abs())))
        .filter(|w| w.is_finite())
        .collect();
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
    for class in [
        PointClass::Inside,
        PointClass::Glass,
        PointClass::Reflection,
        PointClass::Outside,
        PointClass::Unlabelled,
    ] {
        x = legend_entry(canvas, x, y, class.name(), color_of(class)) - 4;
    }
    x = legend_entry(canvas, x, y, "mirrored", MIRRORED) - 4;
    legend_entry(canvas, x, y, "pane", PANE);
}
