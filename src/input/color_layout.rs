//! How colour lies in the bytes of an image, by the name of its encoding, and what it is in red, green and blue.

/// See the module. Samples of 16 bits count by their upper bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ColorLayout {
    /// Samples of a pixel beside each other, of `bytes` each; red, green and blue are those numbered `rgb`.
    Packed { samples: usize, rgb: [usize; 3], bytes: usize },
    /// Two pixels in four bytes: where Y0, U, Y1 and V lie in them.
    Pairs([usize; 4]),
    /// A Bayer mosaic: the colours (0 red, 1 green, 2 blue) of two by two pixels, row by row.
    Mosaic { colors: [usize; 4], bytes: usize },
    /// Brightness of all pixels, then U and V at these places of each pair; one pair for two by two pixels where it is `halved`.
    Planes { uv: [usize; 2], halved: bool },
}

/// The encodings, for messages.
pub(super) const NAMES: &str = "rgb8, bgr8, rgba8, bgra8, rgb16, bgr16, rgba16, bgra16, mono8, 8UC1, 8UC3, 8UC4, bayer_rggb8 and the like, \
                                yuv422 (uyvy), yuv422_yuy2 (yuyv), nv12, nv21 and nv24 are";

impl ColorLayout {
    /// `None` for other encodings. 8UC3 and 8UC4 are taken as BGR(A), OpenCV's order.
    pub(super) fn of(encoding: &str) -> Option<Self> {
        let packed = |samples, rgb, bytes| Some(Self::Packed { samples, rgb, bytes });
        let (rgb, bgr) = ([0, 1, 2], [2, 1, 0]);
        match encoding.to_ascii_lowercase().as_str() {
            "rgb8" => packed(3, rgb, 1),
            "bgr8" | "8uc3" => packed(3, bgr, 1),
            "rgba8" => packed(4, rgb, 1),
            "bgra8" | "8uc4" => packed(4, bgr, 1),
            "rgb16" => packed(3, rgb, 2),
            "bgr16" | "16uc3" => packed(3, bgr, 2),
            "rgba16" => packed(4, rgb, 2),
            "bgra16" | "16uc4" => packed(4, bgr, 2),
            "mono8" | "8uc1" => packed(1, [0; 3], 1),
            "yuv422" | "uyvy" => Some(Self::Pairs([1, 0, 3, 2])),
            "yuv422_yuy2" | "yuyv" => Some(Self::Pairs([0, 1, 2, 3])),
            "nv12" => Some(Self::Planes { uv: [0, 1], halved: true }),
            "nv21" => Some(Self::Planes { uv: [1, 0], halved: true }),
            "nv24" => Some(Self::Planes { uv: [0, 1], halved: false }),
            other => Self::mosaic(other.strip_prefix("bayer_")?),
        }
    }

    /// `rggb8`, `gbrg16` and the like.
    fn mosaic(pattern: &str) -> Option<Self> {
        let (colors, bits) = pattern.split_at_checked(4)?;
        let bytes = ["8", "16"].iter().position(|known| *known == bits)? + 1;
        let colors = match colors {
            "rggb" => [0, 1, 1, 2],
            "bggr" => [2, 1, 1, 0],
            "gbrg" => [1, 2, 0, 1],
            "grbg" => [1, 0, 2, 1],
            _ => return None,
        };
        Some(Self::Mosaic { colors, bytes })
    }

    /// Whether it has one brightness a pixel and no colour.
    pub(super) fn is_grey(self) -> bool {
        matches!(self, Self::Packed { samples: 1, .. })
    }
}

/// Red, green and blue of a mosaic of `width` pixels a row: of a pixel's own colour its sample, of the others the mean of
/// those samples around it that have them.
pub(super) fn demosaiced(samples: &[u8], width: usize, colors: [usize; 4]) -> Vec<u8> {
    let height = samples.len() / width.max(1);
    let mut rgb = Vec::with_capacity(3 * samples.len());
    for y in 0..height {
        for x in 0..width {
            let (mut sums, mut counts) = ([0_u16; 3], [0_u16; 3]);
            for near_y in y.saturating_sub(1)..height.min(y + 2) {
                for near_x in x.saturating_sub(1)..width.min(x + 2) {
                    let color = colors[2 * (near_y % 2) + near_x % 2];
                    sums[color] += u16::from(samples[near_y * width + near_x]);
                    counts[color] += 1;
                }
            }
            let own = samples[y * width + x];
            rgb.extend((0..3).map(|color| match counts[color] {
                _ if color == colors[2 * (y % 2) + x % 2] => own,
                // An image of one row has no row of the third colour.
                0 => own,
                count => u8::try_from((sums[color] + count / 2) / count).unwrap_or(u8::MAX),
            }));
        }
    }
    rgb
}

/// BT.601 with the studio range (Y 16..235), as video cameras send it.
pub(super) fn rgb_of_yuv(y: u8, u: u8, v: u8) -> [u8; 3] {
    let (y, u, v) = (f32::from(y) - 16.0, f32::from(u) - 128.0, f32::from(v) - 128.0);
    let luma = 1.164_383 * y;
    [luma + 1.596_027 * v, luma - 0.391_762 * u - 0.812_968 * v, luma + 2.017_232 * u].map(|channel| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to a byte first"
        )]
        let byte = channel.round().clamp(0.0, 255.0) as u8;
        byte
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mosaic_of_one_colour_is_that_colour() {
        let [red, green, blue] = [200, 90, 30];
        for name in ["bayer_rggb8", "bayer_bggr8", "bayer_gbrg8", "bayer_grbg8"] {
            let Some(ColorLayout::Mosaic { colors, bytes: 1 }) = ColorLayout::of(name) else {
                panic!("{name}")
            };
            let samples: Vec<u8> =
                (0..5 * 4).map(|at| [red, green, blue][colors[2 * ((at / 5) % 2) + (at % 5) % 2]]).collect();
            let rgb = demosaiced(&samples, 5, colors);
            assert!(rgb.chunks(3).all(|pixel| pixel == [red, green, blue]), "{name}: {rgb:?}");
        }
    }

    #[test]
    fn a_missing_colour_is_the_mean_of_its_neighbours() {
        // Red at the corners of three by three pixels, blue in the middle.
        let samples = [10, 1, 20, 2, 99, 3, 30, 4, 41];
        let rgb = demosaiced(&samples, 3, [0, 1, 1, 2]);
        assert_eq!(rgb[3 * 4..3 * 5], [25, 3, 99], "(10 + 20 + 30 + 41) / 4, (1 + 2 + 3 + 4) / 4 rounded");
        assert_eq!(rgb[3..6], [15, 1, 99], "red from left and right, blue from below");
    }

    #[test]
    fn patterns_that_are_none_are_refused() {
        for name in ["bayer_rgbg8", "bayer_rggb12", "bayer_", "bayer_rgg", "bayer_rggb", "bayer_ггbb8"] {
            assert_eq!(ColorLayout::of(name), None, "{name}");
        }
    }
}
