//! An image as it came, decoded only once it is known to be used.

use crate::base::Result;
use crate::input::color_layout::ColorLayout;
use crate::input::image_decode::{Decoded, RawImage, color_from_file, depth_from_compressed};
use crate::message::{bare_frame, decode_error, foxglove, ros2};
use crate::sensor::DepthSamples;

/// How the payload of an [`ImageMessage`] is laid out.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Form {
    Raw(RawLayout),
    File { format: String },
}

/// What an image shows, as far as its encoding tells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Shows {
    Depth,
    Color,
    /// Grey of 8 bits: colour of a grey camera, infrared, confidence, a mask.
    Grey,
    /// Nothing that is read; the encoding's name.
    Other(String),
}

impl Shows {
    fn of_encoding(encoding: &str) -> Self {
        match (encoding.to_ascii_lowercase().as_str(), ColorLayout::of(encoding)) {
            ("16uc1" | "mono16" | "32fc1", _) => Self::Depth,
            (_, Some(layout)) if layout.is_grey() => Self::Grey,
            (_, Some(_)) => Self::Color,
            (_, None) => Self::Other(encoding.into()),
        }
    }

    /// Of a compressed image: a PNG says how many bits it has and of what.
    fn of_file(format: &str, file: &[u8]) -> Self {
        let format = format.to_lowercase();
        if format.contains("compresseddepth") || format.contains("rvl") {
            return Self::Depth;
        }
        let is_grey = format.starts_with("mono8") || format.starts_with("8uc1");
        match file {
            // Signature, length and name of the first chunk, width and height; then bits a sample and kind of colour.
            [0x89, b'P', b'N', b'G', ..] if file.len() > 25 => match (file[24], file[25]) {
                (16, 0) => Self::Depth,
                (_, 0) => Self::Grey,
                _ => Self::Color,
            },
            [0xff, 0xd8, ..] if is_grey => Self::Grey,
            [0xff, 0xd8, ..] => Self::Color,
            _ => Self::Other(format),
        }
    }
}

/// The fields of a [`RawImage`] but its bytes.
#[derive(Debug, Clone, PartialEq, Eq)]
struct RawLayout {
    width: u32,
    height: u32,
    step: u32,
    encoding: String,
    big_endian: bool,
}

impl RawLayout {
    fn image<'a>(&'a self, data: &'a [u8]) -> RawImage<'a> {
        let Self { width, height, step, ref encoding, big_endian } = *self;
        RawImage { width, height, step, encoding, big_endian, data }
    }
}

/// An image with its stamp and frame, not decoded yet.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ImageMessage {
    pub(crate) stamp_ns: u64,
    pub(crate) frame_id: String,
    form: Form,
    data: Vec<u8>,
}

impl ImageMessage {
    pub(crate) fn from_ros_raw(image: ros2::Image) -> Result<Self> {
        let form = Form::Raw(RawLayout {
            width: image.width,
            height: image.height,
            step: image.step,
            encoding: image.encoding,
            big_endian: image.is_bigendian != 0,
        });
        let stamp_ns = image.header.stamp.stamp_ns()?;
        Ok(Self { stamp_ns, frame_id: bare_frame(image.header.frame_id), form, data: image.data })
    }

    pub(crate) fn from_ros_compressed(image: ros2::CompressedImage) -> Result<Self> {
        let stamp_ns = image.header.stamp.stamp_ns()?;
        let form = Form::File { format: image.format };
        Ok(Self { stamp_ns, frame_id: bare_frame(image.header.frame_id), form, data: image.data })
    }

    pub(crate) fn from_foxglove_raw(payload: &[u8]) -> Result<Self> {
        let image: foxglove::RawImage = foxglove::decode_protobuf("foxglove.RawImage", payload)?;
        let form = Form::Raw(RawLayout {
            width: image.width,
            height: image.height,
            step: image.step,
            encoding: image.encoding,
            big_endian: false,
        });
        let stamp_ns = foxglove::stamp_ns(image.timestamp)?;
        Ok(Self { stamp_ns, frame_id: bare_frame(image.frame_id), form, data: image.data })
    }

    pub(crate) fn from_foxglove_compressed(payload: &[u8]) -> Result<Self> {
        let image: foxglove::CompressedImage =
            foxglove::decode_protobuf("foxglove.CompressedImage", payload)?;
        let stamp_ns = foxglove::stamp_ns(image.timestamp)?;
        let form = Form::File { format: image.format };
        Ok(Self { stamp_ns, frame_id: bare_frame(image.frame_id), form, data: image.data })
    }

    /// What it shows.
    pub(crate) fn shows(&self) -> Shows {
        match &self.form {
            Form::Raw(layout) => Shows::of_encoding(&layout.encoding),
            Form::File { format } => Shows::of_file(format, &self.data),
        }
    }

    /// Pixels, `3 * width * height` bytes.
    pub(crate) fn color(&self) -> Result<Decoded<Vec<u8>>> {
        match &self.form {
            Form::Raw(layout) => layout.image(&self.data).color(),
            Form::File { .. } => color_from_file(&self.data),
        }
    }

    /// Depth; integers are counts of `unit_m` metres.
    pub(crate) fn depth(&self, unit_m: f64) -> Result<Decoded<DepthSamples>> {
        match &self.form {
            Form::Raw(layout) => layout.image(&self.data).depth(unit_m),
            Form::File { format } => depth_from_compressed(format, &self.data, unit_m),
        }
    }

    /// Confidence in [0, 1].
    pub(crate) fn confidence(&self) -> Result<Decoded<Vec<f32>>> {
        match &self.form {
            Form::Raw(layout) => layout.image(&self.data).confidence(),
            Form::File { .. } => Err(decode_error("confidence image", "compressed images are not supported")),
        }
    }
}
