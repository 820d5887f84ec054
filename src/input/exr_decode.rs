//! Depth images in OpenEXR.

use std::io::Cursor;

use exr::block;
use exr::math::Vec2;
use exr::meta::header::Header;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, read};

use crate::base::{Error, Result};
use crate::input::image_decode::{Decoded, MAX_SIDE_PX, check_claim};
use crate::message::decode_error;
use crate::sensor::DepthSamples;

/// First bytes of every OpenEXR file.
pub(crate) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

const WHAT: &str = "EXR depth image";

/// Channels that hold depth, the first that is there being read: a depth or single channel, else one
/// of three that are alike.
const CHANNELS: [&str; 5] = ["Y", "Z", "R", "G", "B"];

/// Depth of an OpenEXR file's bytes, metres.
///
/// # Errors
/// [`Error::Decode`] for damaged files, images over the limits of [`crate::input::image_decode`], and files
/// without one of the channels Y, Z, R, G and B.
pub(crate) fn depth_from_exr(file: &[u8]) -> Result<Decoded<DepthSamples>> {
    let chunks = block::read(Cursor::new(file), false).map_err(damaged)?;
    let [header] = chunks.headers() else {
        return Err(refused(format!("it has {} layers in place of one", chunks.headers().len())));
    };
    let channel = depth_channel(header, file.len())?;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required(channel)
        .collect_pixels(
            |size: Vec2<usize>, _| (size.width(), vec![0.0_f32; size.area()]),
            |(width, samples), at, (depth_m,): (f32,)| samples[at.y() * *width + at.x()] = depth_m,
        )
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_chunks(chunks)
        .map_err(damaged)?;
    let layer = image.layer_data;
    let side = |pixels: usize| u32::try_from(pixels).map_err(|_| refused("it is too large"));
    Ok(Decoded {
        width: side(layer.size.width())?,
        height: side(layer.size.height())?,
        samples: DepthSamples::Metres(layer.channel_data.pixels.1),
    })
}

/// The channel to read, after checking what the header asks to be allocated.
fn depth_channel(header: &Header, file_bytes: usize) -> Result<&'static str> {
    let Vec2(width, height) = header.layer_size;
    if width.max(height) > MAX_SIDE_PX as usize {
        return Err(refused(format!("it is {width}x{height}, more than {MAX_SIDE_PX} pixels a side")));
    }
    let bytes = (width * height) as u64 * header.channels.bytes_per_pixel as u64;
    let side = |pixels: usize| u32::try_from(pixels).unwrap_or(u32::MAX);
    check_claim(WHAT, [side(width), side(height)], bytes, file_bytes)?;
    let holds = |name: &&str| header.channels.list.iter().any(|channel| channel.name.eq(name));
    CHANNELS
        .into_iter()
        .find(holds)
        .ok_or_else(|| refused("it has no channel Y, Z, R, G or B, of which one holds depth"))
}

fn damaged(error: exr::error::Error) -> Error {
    refused(error.to_string())
}

fn refused(reason: impl Into<String>) -> Error {
    decode_error(WHAT, reason)
}
