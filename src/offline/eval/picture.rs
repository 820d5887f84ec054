//! What sensor, network and maps look like beside the truth.

use std::path::Path;

use crate::base::Result;
use crate::offline::eval::contest::Entry;
use crate::offline::eval::scene::Scored;
use crate::offline::eval::shown::{DRAWN, Shown};
use crate::output::png::canvas::{Canvas, Rgb, mix};
use crate::output::png::color_of_cost;
use crate::sensor::RgbdFrame;

/// Size of a panel with an image, pixels.
const IMAGE: [u32; 2] = [424, 240];
/// Side of a panel with a map: every cell of the 212 in the middle on 2 x 2 pixels; nothing is seen beyond.
const MAP: u32 = 424;
const CELL: u32 = 2;
const GAP: i64 = 4;

const BACKGROUND: Rgb = [24, 24, 26];
const TEXT: Rgb = [240, 240, 240];
const BLACK: Rgb = [0, 0, 0];
const HOLE: Rgb = [0, 0, 0];
const GLASS: Rgb = [255, 160, 0];
const UNRELIABLE: Rgb = [215, 40, 30];
const RELIABLE: Rgb = [40, 150, 70];

/// Depths drawn at both ends of the palette, metres.
const NEAR_M: f32 = 0.3;
const FAR_M: f32 = 8.0;

/// From near to far.
const PALETTE: [Rgb; 5] = [[250, 235, 90], [240, 120, 50], [190, 40, 110], [90, 25, 140], [20, 20, 60]];

/// Colour of a depth; black for none.
fn color_of_depth(depth_m: f32) -> Rgb {
    if depth_m.is_nan() || depth_m <= 0.0 {
        return HOLE;
    }
    let share = ((depth_m / NEAR_M).ln() / (FAR_M / NEAR_M).ln()).clamp(0.0, 1.0);
    let mut at = share * 4.0;
    let mut step = 0;
    while at > 1.0 && step < PALETTE.len() - 2 {
        at -= 1.0;
        step += 1;
    }
    mix(PALETTE[step], PALETTE[step + 1], at)
}

/// Green where reliable, red where not; black for holes.
fn color_of_reliability(reliability: f32, depth_m: f32) -> Rgb {
    if depth_m > 0.0 { mix(UNRELIABLE, RELIABLE, reliability) } else { HOLE }
}

/// A row-major picture of `width` pixels a row.
pub(crate) struct Panel<'a> {
    /// Written on it.
    pub(crate) label: &'a str,
    /// Pixels a row.
    pub(crate) width: u32,
    /// The pixels.
    pub(crate) pixels: Vec<Rgb>,
}

impl<'a> Panel<'a> {
    /// Colour.
    pub(crate) fn color(label: &'a str, width: u32, rgb: &[u8]) -> Self {
        Self { label, width, pixels: rgb.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect() }
    }

    /// Depth in metres.
    pub(crate) fn depth(label: &'a str, width: u32, depth_m: &[f32]) -> Self {
        Self { label, width, pixels: depth_m.iter().copied().map(color_of_depth).collect() }
    }

    /// Reliability where there is depth.
    pub(crate) fn reliability(label: &'a str, width: u32, reliability: &[f32], depth_m: &[f32]) -> Self {
        let pixels = reliability.iter().zip(depth_m).map(|(&r, &d)| color_of_reliability(r, d));
        Self { label, width, pixels: pixels.collect() }
    }

    /// Red where bad, green where good, black where nothing can be said.
    pub(crate) fn verdict(label: &'a str, width: u32, bad: &[Option<bool>]) -> Self {
        let color = |bad: &Option<bool>| match bad {
            None => HOLE,
            Some(true) => UNRELIABLE,
            Some(false) => RELIABLE,
        };
        Self { label, width, pixels: bad.iter().map(color).collect() }
    }

    /// A square costmap, north up, its middle alone.
    fn costmap(label: &'a str, side: u32, costs: &[u8], glass: impl Fn(usize) -> bool) -> Self {
        let shown = (MAP / CELL).min(side);
        let first = (side - shown) / 2;
        let cells =
            (first..first + shown).rev().flat_map(|y| (first..first + shown).map(move |x| y * side + x));
        let color = |cell: u32| {
            let cell = cell as usize;
            if glass(cell) { GLASS } else { costs.get(cell).map_or(BLACK, |&cost| color_of_cost(cost)) }
        };
        Self { label, width: shown, pixels: cells.map(color).collect() }
    }

    /// Draws it into a box, by the nearest pixel.
    fn draw(&self, canvas: &mut Canvas, [left, top]: [i64; 2], [width, height]: [u32; 2]) {
        let rows = u32::try_from(self.pixels.len()).unwrap_or(0) / self.width.max(1);
        for y in 0..height {
            for x in 0..width {
                let from = (y * rows / height) * self.width + x * self.width / width;
                let color = self.pixels.get(from as usize).copied().unwrap_or(BLACK);
                canvas.set(left + i64::from(x), top + i64::from(y), color);
            }
        }
        canvas.rimmed_text(left + 6, top + 6, self.label, TEXT, BLACK);
    }
}

/// Rows of panels, every row with boxes of its own size.
pub(crate) fn sheet(rows: &[(&[Panel<'_>], [u32; 2])], path: &Path) -> Result<()> {
    let of = |size: u32, count: usize| (i64::from(size) + GAP) * i64::try_from(count).unwrap_or(0);
    let width = rows.iter().map(|(panels, size)| of(size[0], panels.len())).max().unwrap_or(0) - GAP;
    let height = rows.iter().map(|(_, size)| of(size[1], 1)).sum::<i64>() - GAP;
    let whole = |length: i64| u32::try_from(length).unwrap_or(1).max(1);
    let mut canvas = Canvas::new(whole(width), whole(height), BACKGROUND);
    let mut top = 0;
    for (panels, size) in rows {
        for (index, panel) in (0..).zip(*panels) {
            panel.draw(&mut canvas, [index * (i64::from(size[0]) + GAP), top], *size);
        }
        top += i64::from(size[1]) + GAP;
    }
    canvas.save(path)
}

/// Colour on the depth grid where the pair is aligned, else as it is.
fn color_panel(frame: &RgbdFrame) -> Panel<'static> {
    match &frame.color {
        Some(color) => Panel::color("color", color.camera.width, &color.rgb),
        None => Panel { label: "no color", width: 1, pixels: vec![BACKGROUND] },
    }
}

/// A scored frame: colour, depth, true depth, reliability; the costs of some methods beside the true ones.
///
/// # Errors
/// [`crate::Error::File`] or [`crate::Error::Encode`], both with the path.
pub fn save(scored: &Scored, path: &Path) -> Result<()> {
    let is_glass = |cell: usize| scored.window.cells.get(cell) == Some(&crate::sim::truth::GLASS);
    let first = scored.entries.first().map(Entry::map).transpose()?;
    let truth = first.map(|map| Panel::costmap("truth", map.grid.width, &scored.window.costs, is_glass));
    draw(&scored.frame.frame, &scored.entries, Some(&scored.frame.truth.depth_m), truth, path)
}

/// A frame of which no truth is known: colour, depth, reliability; the costs of the same methods.
///
/// # Errors
/// As [`save`].
pub fn save_shown(shown: &Shown, path: &Path) -> Result<()> {
    draw(&shown.frame, &shown.entries, None, None, path)
}

fn draw(
    frame: &RgbdFrame,
    entries: &[Entry],
    true_depth_m: Option<&[f32]>,
    true_map: Option<Panel<'_>>,
    path: &Path,
) -> Result<()> {
    let width = frame.depth.camera.width;
    let measured = crate::offline::eval::depth::measured_m(frame);
    let mut images = vec![color_panel(frame), Panel::depth("depth", width, &measured)];
    images.extend(true_depth_m.map(|depth_m| Panel::depth("true depth", width, depth_m)));
    let mut maps = Vec::new();
    for key in DRAWN {
        let Some(entry) = entries.iter().find(|entry| entry.key == key) else { continue };
        let map = entry.map()?;
        maps.push(Panel::costmap(key, map.grid.width, &map.costmap, |_| false));
        if key == "drm" {
            let images_of = entry.images()?;
            images.push(Panel::reliability("reliability", width, &images_of.reliability, &measured));
        }
    }
    maps.extend(true_map);
    sheet(&[(&images, IMAGE), (&maps, [MAP, MAP])], path)
}
