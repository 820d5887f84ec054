//! An RGB picture to draw on; whatever falls outside is left out.

use std::io::Cursor;
use std::path::Path;

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use crate::base::Result;
use crate::output::png::font::{GLYPH_HEIGHT, GLYPH_WIDTH, glyph};
use crate::output::{encode_error, save_in_folder};

/// Red, green, blue.
pub(crate) type Rgb = [u8; 3];

/// Picture pixels per pixel of the font.
const TEXT_SCALE: i64 = 2;
/// Height of a line of text, pixels.
pub(crate) const TEXT_HEIGHT: i64 = GLYPH_HEIGHT as i64 * TEXT_SCALE;

/// `share` 0 gives `from`, 1 gives `to`.
pub(crate) fn mix(from: Rgb, to: Rgb, share: f32) -> Rgb {
    let share = share.clamp(0.0, 1.0);
    std::array::from_fn(|i| byte(f32::from(from[i]) * (1.0 - share) + f32::from(to[i]) * share))
}

/// Rounded and clamped to 0..=255.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "float-to-integer casts saturate; NaN becomes 0"
)]
pub(crate) fn byte(value: f32) -> u8 {
    value.round() as u8
}

/// Pixels from the top left, x right and y down.
pub(crate) struct Canvas {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

impl Canvas {
    pub(crate) fn new(width: u32, height: u32, background: Rgb) -> Self {
        let rgb = background.repeat(width as usize * height as usize);
        Self { width, height, rgb }
    }

    pub(crate) fn set(&mut self, x: i64, y: i64, color: Rgb) {
        if (0..i64::from(self.width)).contains(&x) && (0..i64::from(self.height)).contains(&y) {
            // Both are in range and so fit.
            let offset = usize::try_from(3 * (y * i64::from(self.width) + x)).unwrap_or_default();
            self.rgb[offset..offset + 3].copy_from_slice(&color);
        }
    }

    pub(crate) fn fill(&mut self, x: i64, y: i64, width: i64, height: i64, color: Rgb) {
        for row in y..y + height {
            for column in x..x + width {
                self.set(column, row, color);
            }
        }
    }

    /// A filled rectangle with a border of one pixel.
    pub(crate) fn fill_framed(&mut self, x: i64, y: i64, width: i64, height: i64, color: Rgb, border: Rgb) {
        self.fill(x - 1, y - 1, width + 2, height + 2, border);
        self.fill(x, y, width, height, color);
    }

    /// Text whose top left corner is (`x`, `y`); gives the x where it ends.
    pub(crate) fn text(&mut self, x: i64, y: i64, text: &str, color: Rgb) -> i64 {
        let mut left = x;
        for character in text.chars() {
            for (rows, bits) in (0..).zip(glyph(character)) {
                for column in (0..GLYPH_WIDTH).filter(|c| bits >> (GLYPH_WIDTH - 1 - c) & 1 == 1) {
                    let pixel = (left + i64::from(column) * TEXT_SCALE, y + rows * TEXT_SCALE);
                    self.fill(pixel.0, pixel.1, TEXT_SCALE, TEXT_SCALE, color);
                }
            }
            left += (i64::from(GLYPH_WIDTH) + 1) * TEXT_SCALE;
        }
        left
    }

    /// Text with a dark rim, legible on any ground.
    pub(crate) fn rimmed_text(&mut self, x: i64, y: i64, text: &str, color: Rgb, rim: Rgb) {
        for (dx, dy) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
            self.text(x + dx, y + dy, text, rim);
        }
        self.text(x, y, text, color);
    }

    /// A filled triangle with corners in pixels.
    pub(crate) fn triangle(&mut self, corners: [[f64; 2]; 3], color: Rgb) {
        let [a, b, c] = corners;
        // Twice the signed area of p and the edge from `from` to `to`.
        let side = |from: [f64; 2], to: [f64; 2], p: [f64; 2]| {
            (to[0] - from[0]) * (p[1] - from[1]) - (to[1] - from[1]) * (p[0] - from[0])
        };
        let Some([left, top, right, bottom]) = self.bounds(corners) else { return };
        for y in top..=bottom {
            for x in left..=right {
                #[expect(clippy::cast_precision_loss, reason = "pixel numbers are small")]
                let p = [x as f64, y as f64];
                let sides = [side(a, b, p), side(b, c, p), side(c, a, p)];
                if sides.iter().all(|&s| s >= 0.0) || sides.iter().all(|&s| s <= 0.0) {
                    self.set(x, y, color);
                }
            }
        }
    }

    /// Left, top, right and bottom pixel of the corners' box inside the picture; `None` where a corner is not finite.
    #[expect(clippy::cast_possible_truncation, reason = "clamped to the picture first")]
    fn bounds(&self, corners: [[f64; 2]; 3]) -> Option<[i64; 4]> {
        if corners.iter().flatten().any(|c| !c.is_finite()) {
            return None;
        }
        let range = |axis: usize, size: u32| {
            let values = corners.map(|corner| corner[axis]);
            let low = values.iter().copied().fold(f64::INFINITY, f64::min);
            let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            (low.floor().clamp(0.0, f64::from(size)) as i64, high.ceil().clamp(-1.0, f64::from(size)) as i64)
        };
        let (left, right) = range(0, self.width);
        let (top, bottom) = range(1, self.height);
        Some([left, top, right, bottom])
    }

    /// Writes the picture as PNG.
    pub(crate) fn save(&self, path: &Path) -> Result<()> {
        let mut bytes = Cursor::new(Vec::new());
        PngEncoder::new(&mut bytes)
            .write_image(&self.rgb, self.width, self.height, ExtendedColorType::Rgb8)
            .map_err(|e| encode_error(path, e))?;
        save_in_folder(path, &bytes.into_inner())
    }
}
