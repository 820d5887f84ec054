//! Image payloads to pixels: raw encodings of ROS and Foxglove, JPEG, PNG and `compressedDepth`.
//!
//! Sizes are checked against the payload before anything is allocated, so hostile messages cost no
//! more than a few times their own size (compressed images: at most [`MAX_SIDE_PX`] squared pixels
//! and [`MAX_DECODER_BYTES`]).

use std::io::{Cursor, Read};
use std::path::Path;

use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use crate::base::{Error, Result};
use crate::input::color_layout::{self, ColorLayout, demosaiced, rgb_of_yuv};
use crate::input::start::open_file;
use crate::input::{exr_decode, rvl};
use crate::message::decode_error;
use crate::sensor::DepthSamples;

/// Largest width and height of a compressed image, pixels.
pub const MAX_SIDE_PX: u32 = 8192;

/// Largest memory a JPEG or PNG decoder may ask for, bytes.
pub const MAX_DECODER_BYTES: u64 = 256 << 20;

/// Most bytes of pixels that come of a packed byte: deflate gives up to 1032, JPEG at a bit a block of four times four
/// subsampled colours 1365.
const MOST_UNPACKED: u64 = 1400;

const DEPTH_ENCODINGS: &str = "16UC1, mono16 and 32FC1 are";
const CONFIDENCE_ENCODINGS: &str = "mono8, 8UC1 and 32FC1 are";

const PNG_MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Bytes before the PNG or RVL code of a `compressedDepth` payload: an i32 and two f32.
const COMPRESSED_DEPTH_HEADER: usize = 12;

/// Decoded pixels and their grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Decoded<T> {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Row-major samples.
    pub samples: T,
}

/// An uncompressed image as a message carries it.
#[derive(Debug, Clone, Copy)]
pub struct RawImage<'a> {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Bytes from one row to the next; may be more than a row's pixels take.
    pub step: u32,
    /// Name of the pixel layout.
    pub encoding: &'a str,
    /// Byte order of samples of more than a byte.
    pub big_endian: bool,
    /// `step * height` bytes; what follows the last row's pixels may be missing.
    pub data: &'a [u8],
}

impl<'a> RawImage<'a> {
    /// The rows' pixels without padding, after checking that all of them are there.
    fn rows(&self, bytes_per_pixel: usize) -> Result<impl Iterator<Item = &'a [u8]> + use<'a>> {
        let (width, height, step) = (self.width as usize, self.height as usize, self.step as usize);
        let bad = |reason: String| Err(decode_error(format!("{} image", self.encoding), reason));
        if width == 0 || height == 0 {
            return bad(format!("its size is {width}x{height}"));
        }
        let row = width * bytes_per_pixel;
        if step < row {
            return bad(format!("step is {step} bytes, but {width} pixels take {row}"));
        }
        let needed = (height - 1).checked_mul(step).and_then(|bytes| bytes.checked_add(row));
        if needed.is_none_or(|needed| needed > self.data.len()) {
            return bad(format!(
                "{width}x{height} with a step of {step} does not fit its payload of {} bytes",
                self.data.len()
            ));
        }
        Ok(self.data.chunks(step).take(height).map(move |line| &line[..row]))
    }

    fn unknown(&self, what: &str, supported: &str) -> Error {
        decode_error(what, format!("encoding `{}` is not supported; {supported}", self.encoding))
    }

    fn decoded<T>(&self, samples: T) -> Decoded<T> {
        Decoded { width: self.width, height: self.height, samples }
    }

    fn floats(&self) -> Result<Vec<f32>> {
        let convert = if self.big_endian { f32::from_be_bytes } else { f32::from_le_bytes };
        Ok(self.rows(4)?.flat_map(|row| row.as_chunks::<4>().0.iter().map(|&bytes| convert(bytes))).collect())
    }

    /// Colour, `3 * width * height` bytes. 8UC3 and 8UC4 are taken as BGR(A), OpenCV's order; of samples of 16 bits the upper
    /// bytes count.
    ///
    /// # Errors
    /// [`Error::Decode`] for unknown encodings and sizes that do not fit the payload.
    pub fn color(&self) -> Result<Decoded<Vec<u8>>> {
        let unknown = || self.unknown("colour image", color_layout::NAMES);
        let rgb = match ColorLayout::of(self.encoding).ok_or_else(unknown)? {
            ColorLayout::Packed { samples, rgb, bytes } => self.packed(samples, rgb, bytes)?,
            ColorLayout::Pairs(order) => self.pairs(order)?,
            ColorLayout::Mosaic { colors, bytes } => {
                let samples: Vec<u8> = self.upper_bytes(1, bytes)?.collect();
                demosaiced(&samples, self.width as usize, colors)
            }
            ColorLayout::Planes { uv, halved } => self.planes(uv, halved)?,
        };
        Ok(self.decoded(rgb))
    }

    /// The upper bytes of all samples, row by row.
    fn upper_bytes(&self, samples: usize, bytes: usize) -> Result<impl Iterator<Item = u8> + use<'a>> {
        let upper = if self.big_endian { 0 } else { bytes - 1 };
        Ok(self.rows(samples * bytes)?.flat_map(move |row| row.iter().skip(upper).step_by(bytes).copied()))
    }

    fn packed(&self, samples: usize, [r, g, b]: [usize; 3], bytes: usize) -> Result<Vec<u8>> {
        if bytes > 1 {
            let all: Vec<u8> = self.upper_bytes(samples, bytes)?.collect();
            return Ok(all.chunks_exact(samples).flat_map(|px| [px[r], px[g], px[b]]).collect());
        }
        let rows = self.rows(samples)?;
        let mut rgb = Vec::with_capacity(3 * self.width as usize * self.height as usize);
        for row in rows {
            if samples == 3 && r == 0 {
                rgb.extend_from_slice(row);
            } else {
                rgb.extend(row.chunks_exact(samples).flat_map(|px| [px[r], px[g], px[b]]));
            }
        }
        Ok(rgb)
    }

    /// `order`: where Y0, U, Y1 and V lie in the four bytes of a pair of pixels.
    fn pairs(&self, order: [usize; 4]) -> Result<Vec<u8>> {
        if !self.width.is_multiple_of(2) {
            return Err(decode_error(
                format!("{} image", self.encoding),
                format!("its width {} is odd, but pixels come in pairs", self.width),
            ));
        }
        let mut rgb = Vec::new();
        for row in self.rows(2)? {
            for pair in row.chunks_exact(4) {
                let [y0, u, y1, v] = order.map(|at| pair[at]);
                rgb.extend(rgb_of_yuv(y0, u, v));
                rgb.extend(rgb_of_yuv(y1, u, v));
            }
        }
        Ok(rgb)
    }

    /// Brightness of all pixels, then the pairs of U and V. Some drivers count both into `step`: then rows follow each other
    /// without a gap.
    fn planes(&self, [u, v]: [usize; 2], halved: bool) -> Result<Vec<u8>> {
        let (width, height) = (self.width as usize, self.height as usize);
        let (pair_columns, pair_rows) =
            if halved { (width.div_ceil(2), height.div_ceil(2)) } else { (width, height) };
        let bytes_of = |step: usize| {
            let pairs_step = if halved { step.next_multiple_of(2) } else { 2 * step };
            let end = pairs_step.checked_mul(pair_rows - 1)?.checked_add(2 * pair_columns)?;
            Some((step.checked_mul(height)?, pairs_step, step.checked_mul(height)?.checked_add(end)?))
        };
        self.rows(1).map(drop)?;
        let fits = [self.step as usize, width].into_iter().filter_map(|step| Some((step, bytes_of(step)?)));
        let fit = fits.into_iter().find(|(_, (_, _, end))| *end <= self.data.len());
        let Some((step, (pairs_at, pairs_step, _))) = fit else {
            let bytes = self.data.len();
            let reason =
                format!("the colours of {width}x{height} pixels do not fit its payload of {bytes} bytes");
            return Err(decode_error(format!("{} image", self.encoding), reason));
        };
        let mut rgb = Vec::with_capacity(3 * width * height);
        for y in 0..height {
            let pairs = &self.data[pairs_at + pairs_step * if halved { y / 2 } else { y }..];
            for (x, &luma) in self.data[y * step..][..width].iter().enumerate() {
                let pair = &pairs[2 * if halved { x / 2 } else { x }..];
                rgb.extend(rgb_of_yuv(luma, pair[u], pair[v]));
            }
        }
        Ok(rgb)
    }

    /// Depth; integers are counts of `unit_m` metres, floats metres.
    ///
    /// # Errors
    /// [`Error::Decode`] for unknown encodings and sizes that do not fit the payload.
    pub fn depth(&self, unit_m: f64) -> Result<Decoded<DepthSamples>> {
        let samples = match self.encoding.to_ascii_lowercase().as_str() {
            "16uc1" | "mono16" => DepthSamples::Integer { raw: self.integers()?, unit_m },
            "32fc1" => DepthSamples::Metres(self.floats()?),
            _ => return Err(self.unknown("depth image", DEPTH_ENCODINGS)),
        };
        Ok(self.decoded(samples))
    }

    fn integers(&self) -> Result<Vec<u16>> {
        let convert = if self.big_endian { u16::from_be_bytes } else { u16::from_le_bytes };
        Ok(self.rows(2)?.flat_map(|row| row.as_chunks::<2>().0.iter().map(|&bytes| convert(bytes))).collect())
    }

    /// Confidence in [0, 1]: bytes as shares of 255, floats clamped, NaN as 0.
    ///
    /// # Errors
    /// [`Error::Decode`] for unknown encodings and sizes that do not fit the payload.
    pub fn confidence(&self) -> Result<Decoded<Vec<f32>>> {
        let samples = match self.encoding.to_ascii_lowercase().as_str() {
            "mono8" | "8uc1" => {
                self.rows(1)?.flat_map(|row| row.iter().map(|&byte| f32::from(byte) / 255.0)).collect()
            }
            "32fc1" => {
                let share = |value: f32| if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) };
                self.floats()?.into_iter().map(share).collect()
            }
            _ => return Err(self.unknown("confidence image", CONFIDENCE_ENCODINGS)),
        };
        Ok(self.decoded(samples))
    }
}

/// An image file's bytes, at most [`MAX_DECODER_BYTES`] of them.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let file = open_file(path)?;
    file.take(MAX_DECODER_BYTES).read_to_end(&mut bytes).map_err(Error::file(path))?;
    Ok(bytes)
}

/// A JPEG or PNG, recognised by its content, within the limits of this module.
fn read_image(what: &str, file: &[u8]) -> Result<DynamicImage> {
    let format = image::guess_format(file)
        .ok()
        .filter(|format| matches!(format, ImageFormat::Jpeg | ImageFormat::Png))
        .ok_or_else(|| decode_error(what, "the payload is neither JPEG nor PNG, which are supported"))?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_SIDE_PX);
    limits.max_image_height = Some(MAX_SIDE_PX);
    limits.max_alloc = Some(MAX_DECODER_BYTES);
    let mut reader = ImageReader::with_format(Cursor::new(file), format);
    reader.limits(limits);
    let failed = |error: ImageError| decode_error(what, error.to_string());
    let decoder = reader.into_decoder().map_err(failed)?;
    let (width, height) = decoder.dimensions();
    check_claim(what, [width, height], decoder.total_bytes(), file.len())?;
    DynamicImage::from_decoder(decoder).map_err(failed)
}

/// Refuses an image that says to unpack to more than its bytes can hold, before memory is taken for it.
///
/// # Errors
/// [`Error::Decode`].
pub(in crate::input) fn check_claim(
    what: &str,
    [width, height]: [u32; 2],
    claimed: u64,
    packed: usize,
) -> Result<()> {
    let reason = if claimed > MAX_DECODER_BYTES {
        format!("it is {width}x{height}: its pixels take {} MiB, at most 256 are read", claimed >> 20)
    } else if claimed > MOST_UNPACKED.saturating_mul(packed as u64) {
        format!("it says that it is {width}x{height}, which is more than its {packed} bytes can hold")
    } else {
        return Ok(());
    };
    Err(decode_error(what, reason))
}

/// Colour of a JPEG or PNG file's bytes, `3 * width * height`.
///
/// # Errors
/// [`Error::Decode`] for other formats, damaged files and images over the limits.
pub fn color_from_file(file: &[u8]) -> Result<Decoded<Vec<u8>>> {
    let image = read_image("compressed colour image", file)?;
    Ok(Decoded { width: image.width(), height: image.height(), samples: image.into_rgb8().into_raw() })
}

/// Depth of an image file's bytes: a 16-bit grey PNG, in counts of `unit_m` metres, or OpenEXR, metres.
///
/// # Errors
/// [`Error::Decode`] for other formats, damaged files and images over the limits.
pub fn depth_from_file(file: &[u8], unit_m: f64) -> Result<Decoded<DepthSamples>> {
    if file.starts_with(&exr_decode::MAGIC) {
        return exr_decode::depth_from_exr(file);
    }
    depth_from_png(file, unit_m)
}

/// Depth of a 16-bit grey PNG file's bytes, in counts of `unit_m` metres.
///
/// # Errors
/// [`Error::Decode`] for other formats, damaged files and images over the limits.
pub fn depth_from_png(file: &[u8], unit_m: f64) -> Result<Decoded<DepthSamples>> {
    let image = counts_from_png(file)?;
    let samples = DepthSamples::Integer { raw: image.samples, unit_m };
    Ok(Decoded { width: image.width, height: image.height, samples })
}

fn counts_from_png(file: &[u8]) -> Result<Decoded<Vec<u16>>> {
    match read_image("compressed depth image", file)? {
        DynamicImage::ImageLuma16(image) => {
            Ok(Decoded { width: image.width(), height: image.height(), samples: image.into_raw() })
        }
        other => Err(decode_error(
            "compressed depth image",
            format!("its pixels are {:?}, but 16-bit grey is what depth takes", other.color()),
        )),
    }
}

/// Depth of a ROS `CompressedImage`: a 16-bit PNG, or `compressedDepth`, whose PNG or RVL code follows a header of
/// an i32 and the two f32 A and B, with 32FC1 quantised as inverse depth: depth = A / (raw - B), 0 invalid.
///
/// # Errors
/// [`Error::Decode`] for other formats, damaged files and images over the limits.
pub fn depth_from_compressed(format: &str, payload: &[u8], unit_m: f64) -> Result<Decoded<DepthSamples>> {
    let format = format.to_lowercase();
    let (is_rvl, is_float) = (format.contains("rvl"), format.trim_start().starts_with("32fc1"));
    let is_bare = payload.starts_with(PNG_MAGIC) && !is_float;
    if is_bare || !(format.contains("compresseddepth") || is_rvl) {
        return depth_from_png(payload, unit_m);
    }
    let Some((header, body)) = payload.split_first_chunk::<COMPRESSED_DEPTH_HEADER>() else {
        return Err(decode_error("compressedDepth image", "the payload ends within its header of 12 bytes"));
    };
    let image =
        if is_rvl && !body.starts_with(PNG_MAGIC) { rvl::decode(body)? } else { counts_from_png(body)? };
    let samples = match is_float {
        true => inverse_depth(header, &image.samples),
        false => DepthSamples::Integer { raw: image.samples, unit_m },
    };
    Ok(Decoded { width: image.width, height: image.height, samples })
}

/// Metres of counts of inverse depth, by the header of `compressedDepth`.
fn inverse_depth(header: &[u8; COMPRESSED_DEPTH_HEADER], counts: &[u16]) -> DepthSamples {
    let [_, _, _, _, a0, a1, a2, a3, b0, b1, b2, b3] = *header;
    let (a, b) = (f32::from_le_bytes([a0, a1, a2, a3]), f32::from_le_bytes([b0, b1, b2, b3]));
    let depth_m = |&raw: &u16| if raw == 0 { f32::NAN } else { a / (f32::from(raw) - b) };
    DepthSamples::Metres(counts.iter().map(depth_m).collect())
}
