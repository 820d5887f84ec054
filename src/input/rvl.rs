//! RVL, the lossless code of depth images in `compressedDepth` topics (A. D. Wilson, Fast Lossless Depth Image Compression,
//! ISS 2017; compressed_depth_image_transport puts the columns and rows before it, two little-endian u32).
//!
//! Pixels come as runs: so many zeros, so many others, each of these as its difference to the one before, whose sign is the
//! lowest bit. All numbers are written three bits a nibble, the fourth says that more follow; eight nibbles, the first in
//! the highest bits, make a little-endian word.

use crate::base::Result;
use crate::input::image_decode::{Decoded, MAX_SIDE_PX};
use crate::message::decode_error;

/// Most pixels of an image: zeros take no room in the payload, so that its length bounds nothing.
const MAX_PIXELS: u64 = 1 << 24;

/// The counts of an image.
///
/// # Errors
/// [`crate::Error::Decode`] for payloads that end early, runs beyond the image and images over the limits.
pub(crate) fn decode(payload: &[u8]) -> Result<Decoded<Vec<u16>>> {
    let bad = |reason: String| decode_error("RVL image", reason);
    let Some((&[w0, w1, w2, w3, h0, h1, h2, h3], code)) = payload.split_first_chunk::<8>() else {
        return Err(bad("the payload ends within its size".into()));
    };
    let [width, height] = [u32::from_le_bytes([w0, w1, w2, w3]), u32::from_le_bytes([h0, h1, h2, h3])];
    let pixels = u64::from(width) * u64::from(height);
    let sides = 1..=MAX_SIDE_PX;
    if !sides.contains(&width) || !sides.contains(&height) || pixels > MAX_PIXELS {
        return Err(bad(format!("its size is {width}x{height}; 1 to {MAX_PIXELS} pixels are supported")));
    }
    let pixels = usize::try_from(pixels).map_err(|error| bad(error.to_string()))?;
    let samples = Nibbles { code, word: 0, left: 0 }.pixels(pixels).map_err(bad)?;
    Ok(Decoded { width, height, samples })
}

struct Nibbles<'a> {
    code: &'a [u8],
    word: u32,
    /// Nibbles of the word that are not read yet.
    left: u32,
}

impl Nibbles<'_> {
    fn pixels(&mut self, pixels: usize) -> Result<Vec<u16>, String> {
        // A pixel that is not 0 takes a nibble at least.
        let mut samples = Vec::with_capacity(pixels.min(2 * self.code.len()));
        let mut before = 0_u16;
        while samples.len() < pixels {
            let zeros = self.run(pixels, samples.len())?;
            samples.resize(samples.len() + zeros, 0);
            for _ in 0..self.run(pixels, samples.len())? {
                let folded = self.number().ok_or_else(|| ended(samples.len(), pixels))?;
                // The sign is the lowest bit; counts wrap around at 16 bits, as in the encoder.
                let step = (folded >> 1) ^ (folded & 1).wrapping_neg();
                before = before.wrapping_add(low_half(step));
                samples.push(before);
            }
        }
        Ok(samples)
    }

    /// The length of a run, which lies within the image.
    fn run(&mut self, pixels: usize, done: usize) -> Result<usize, String> {
        let run = self.number().ok_or_else(|| ended(done, pixels))?;
        let fits = usize::try_from(run).ok().filter(|&run| run <= pixels - done);
        fits.ok_or_else(|| format!("a run of {run} pixels after {done} goes beyond its {pixels}"))
    }

    /// The next number; `None` where the code ends, or for more than 32 bits.
    fn number(&mut self) -> Option<u32> {
        let mut number = 0_u32;
        for shift in (0..=30).step_by(3) {
            let nibble = self.nibble()?;
            number |= (nibble & 7) << shift;
            if nibble & 8 == 0 {
                return Some(number);
            }
        }
        None
    }

    fn nibble(&mut self) -> Option<u32> {
        if self.left == 0 {
            let (&word, rest) = self.code.split_first_chunk::<4>()?;
            (self.word, self.code, self.left) = (u32::from_le_bytes(word), rest, 8);
        }
        self.left -= 1;
        Some((self.word >> (4 * self.left)) & 15)
    }
}

fn ended(done: usize, pixels: usize) -> String {
    format!("the payload ends, or holds a number that is none, after {done} of {pixels} pixels")
}

fn low_half(word: u32) -> u16 {
    let [low, high, _, _] = word.to_le_bytes();
    u16::from_le_bytes([low, high])
}
