//! Drives from above as PNG: the trials of one world side by side.

use std::path::Path;

use super::record::{Picture, Record};
use crate::base::Result;
use crate::output::png::canvas::{Canvas, Rgb, TEXT_HEIGHT};

/// Picture pixels of a metre.
const PIXELS_PER_M: f64 = 40.0;

/// Around panels, pixels.
const MARGIN: i64 = 8;

const GROUND: Rgb = [0x70, 0x89, 0x86];
const FREE: Rgb = [48, 48, 48];
const GRADED: Rgb = [96, 64, 160];
const INSCRIBED: Rgb = [0, 200, 200];
const LETHAL: Rgb = [255, 0, 255];
const SOLID: Rgb = [255, 255, 255];
const GLASS: Rgb = [127, 215, 255];
const PASSABLE: Rgb = [80, 204, 80];
const PLAN: Rgb = [255, 255, 0];
const DRIVEN: Rgb = [0, 255, 0];
const IDEAL: Rgb = [190, 190, 190];
const STOP: Rgb = [255, 32, 32];

/// Writes the drives of one world, each with its map halfway through the time it took.
///
/// # Errors
/// [`crate::Error::File`], [`crate::Error::Encode`].
pub fn save(records: &[&Record], path: &Path) -> Result<()> {
    let sizes: Vec<[i64; 2]> = records.iter().map(|record| size(record)).collect();
    let width: i64 = sizes.iter().map(|[width, _]| width + MARGIN).sum::<i64>() + MARGIN;
    let height = sizes.iter().map(|[_, height]| *height).max().unwrap_or(0) + 2 * TEXT_HEIGHT + 4 * MARGIN;
    let pixels = |length: i64| u32::try_from(length).unwrap_or(1);
    let mut canvas = Canvas::new(pixels(width), pixels(height), [20, 20, 20]);
    let mut left = MARGIN;
    for (record, [width, height]) in records.iter().zip(sizes) {
        Panel { canvas: &mut canvas, record, left, top: 2 * TEXT_HEIGHT + 3 * MARGIN, height }.draw(width);
        left += width + MARGIN;
    }
    canvas.save(path)
}

/// Pixels of a record's world.
fn size(record: &Record) -> [i64; 2] {
    record.truth.as_ref().map_or([240, 240], |truth| {
        let rows = rows(truth);
        [truth.width as usize, rows].map(|cells| pixel(count(cells) * truth.cell_m * PIXELS_PER_M))
    })
}

fn rows(picture: &Picture) -> usize {
    letters(picture).count() / picture.width.max(1) as usize
}

/// The letters of all cells.
fn letters(picture: &Picture) -> impl Iterator<Item = char> + '_ {
    let mut rest = picture.runs.as_str();
    std::iter::from_fn(move || {
        let letter = rest.chars().next()?;
        let digits = rest[1..].find(|c: char| !c.is_ascii_digit()).map_or(rest.len(), |end| end + 1);
        let length: usize = rest[1..digits].parse().ok()?;
        rest = &rest[digits..];
        Some(std::iter::repeat_n(letter, length))
    })
    .flatten()
}

#[expect(clippy::cast_precision_loss, reason = "cells of a map")]
fn count(cells: usize) -> f64 {
    cells as f64
}

#[expect(clippy::cast_possible_truncation, reason = "pixels of a picture; casts saturate")]
fn pixel(at: f64) -> i64 {
    at.round() as i64
}

/// A trial on the canvas.
struct Panel<'a> {
    canvas: &'a mut Canvas,
    record: &'a Record,
    left: i64,
    top: i64,
    height: i64,
}

impl Panel<'_> {
    fn draw(&mut self, width: i64) {
        let record = self.record;
        self.canvas.fill(self.left, self.top, width, self.height, GROUND);
        let title = format!("{} {}", record.method, record.level);
        self.canvas.text(self.left, MARGIN, &title, SOLID);
        self.canvas.text(self.left, 2 * MARGIN + TEXT_HEIGHT, &record.outcome.name(), SOLID);
        let half_s = record.steps.last().map_or(0.0, |step| step.t_s / 2.0);
        let map = record.pictures.iter().take_while(|picture| picture.t_s <= half_s).last();
        if let Some(map) = map.or(record.pictures.first()) {
            self.cells(map, width);
            self.line(&map.path, PLAN);
        }
        for thing in &record.outlines {
            let color = match thing.kind.as_str() {
                "glass" => GLASS,
                "passable" => PASSABLE,
                _ => SOLID,
            };
            let mut corners = thing.corners.clone();
            if corners.len() > 2 {
                corners.extend(thing.corners.first());
            }
            self.line(&corners, color);
        }
        self.line(&record.ideal, IDEAL);
        let way: Vec<[f64; 2]> = record.steps.iter().map(|step| [step.pose[0], step.pose[1]]).collect();
        self.line(&way, DRIVEN);
        for event in record.events.iter().filter(|event| event.what == "stop") {
            if let Some(step) = record.steps.iter().find(|step| step.t_s >= event.t_s) {
                self.dot([step.pose[0], step.pose[1]], 8, STOP);
            }
        }
        self.dot(record.task[1], 12, DRIVEN);
    }

    /// Pixel of a place in the map.
    fn at(&self, [x, y]: [f64; 2]) -> [i64; 2] {
        let origin = self.record.truth.as_ref().map_or([0.0; 2], |truth| truth.origin_m);
        let [x, y] = [x - origin[0], y - origin[1]].map(|m| pixel(m * PIXELS_PER_M));
        [self.left + x, self.top + self.height - y]
    }

    fn cells(&mut self, map: &Picture, width: i64) {
        let side = pixel(map.cell_m * PIXELS_PER_M);
        let columns = map.width.max(1) as usize;
        for (index, letter) in letters(map).enumerate() {
            let color = match letter {
                'f' => FREE,
                'g' => GRADED,
                'i' => INSCRIBED,
                'l' => LETHAL,
                _ => continue,
            };
            let place = [index % columns, index / columns + 1].map(|cell| count(cell) * map.cell_m);
            let [x, y] = self.at([map.origin_m[0] + place[0], map.origin_m[1] + place[1]]);
            let inside = x >= self.left
                && x + side <= self.left + width
                && y >= self.top
                && y + side <= self.top + self.height;
            if inside {
                self.canvas.fill(x, y, side, side, color);
            }
        }
    }

    fn line(&mut self, corners: &[[f64; 2]], color: Rgb) {
        for pair in corners.windows(2) {
            let [a, b] = [self.at(pair[0]), self.at(pair[1])];
            let steps = (b[0] - a[0]).abs().max((b[1] - a[1]).abs()).max(1);
            for step in 0..=steps {
                let [x, y] = [0, 1].map(|axis| a[axis] + (b[axis] - a[axis]) * step / steps);
                self.canvas.fill(x, y, 2, 2, color);
            }
        }
    }

    fn dot(&mut self, at: [f64; 2], side: i64, color: Rgb) {
        let [x, y] = self.at(at);
        self.canvas.fill_framed(x - side / 2, y - side / 2, side, side, color, [0; 3]);
    }
}
