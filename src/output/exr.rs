//! Buffers of every frame as OpenEXR images, with the frame's figures as JSON beside them.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};

use ::exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};
use serde::Serialize;

use crate::base::Rigid;
use crate::base::{Error, Result};
use crate::config::Config;
use crate::frame::{Counters, FrameOutput};
use crate::output::{Sink, create_folder, encode_error, pass_sums_ms};
use crate::sensor::RgbdFrame;

/// Writes `DIR/NNNNNN/<buffer>.exr` and `DIR/NNNNNN/frame.json`, `NNNNNN` being the frame's index.
///
/// Each EXR has one 32-bit float channel `Y`. Images (`depth_m`, `reliability`) have their own size; grids
/// (`evidence`, `occupancy`, `occupied`, `costmap`) are stored with row 0 = smallest y.
pub struct DumpSink {
    folder: PathBuf,
}

impl DumpSink {
    /// Creates the folder `folder` unless it is there.
    ///
    /// # Errors
    /// [`Error::File`] where it cannot be created.
    pub fn create(folder: &Path, _config: &Config) -> Result<Self> {
        create_folder(folder)?;
        Ok(Self { folder: folder.into() })
    }
}

impl Sink for DumpSink {
    fn write(&mut self, _input: &RgbdFrame, output: &FrameOutput) -> Result<()> {
        let folder = self.folder.join(format!("{:06}", output.index));
        create_folder(&folder)?;
        let write = |name: &str, size, samples| write_exr(&folder.join(format!("{name}.exr")), size, samples);

        let cells = (output.grid.width as usize, output.grid.height as usize);
        write("costmap", cells, output.costmap.iter().map(|&cost| f32::from(cost)).collect())?;
        if let Some(layers) = &output.layers {
            write("evidence", cells, layers.evidence.clone())?;
            write("occupancy", cells, layers.occupancy.clone())?;
            write("occupied", cells, layers.occupied.clone())?;
        }
        if let Some(images) = &output.images {
            let pixels = (images.width as usize, images.height as usize);
            write("depth_m", pixels, images.depth_m.clone())?;
            write("reliability", pixels, images.reliability.clone())?;
        }
        write_json(&folder.join("frame.json"), &FrameRecord::of(output))
    }

    fn finish(&mut self) -> Result<()> {
        Ok(())
    }
}

/// An image of `size` (width, height) with one 32-bit float channel `Y`.
///
/// # Errors
/// [`Error::File`], [`Error::Encode`] where the samples do not fill it.
pub(crate) fn write_exr(path: &Path, size: (usize, usize), samples: Vec<f32>) -> Result<()> {
    if size.0 * size.1 != samples.len() || samples.is_empty() {
        return Err(encode_error(
            path,
            format!("{} samples do not fill {}x{}", samples.len(), size.0, size.1),
        ));
    }
    let channel = AnyChannel::new("Y", FlatSamples::F32(samples));
    let channels = AnyChannels::sort([channel].into_iter().collect());
    let layer = Layer::new(size, LayerAttributes::default(), Encoding::SMALL_FAST_LOSSLESS, channels);
    // Frames are written beside the GPU's work: one thread is enough and leaves the others alone.
    let mut bytes = Cursor::new(Vec::new());
    let written = Image::from_layer(layer).write().non_parallel().to_buffered(&mut bytes);
    written.map_err(|e| encode_error(path, e))?;
    std::fs::write(path, bytes.into_inner()).map_err(Error::file(path))
}

pub(super) fn write_json(path: &Path, record: &impl Serialize) -> Result<()> {
    let mut text = serde_json::to_string_pretty(record).map_err(|e| encode_error(path, e))?;
    text.push('\n');
    std::fs::write(path, text).map_err(Error::file(path))
}

/// `frame.json`.
#[derive(Serialize)]
struct FrameRecord<'a> {
    stamp_ns: u64,
    map_from_base: PoseRecord,
    base_from_camera: PoseRecord,
    origin_x_m: f64,
    origin_y_m: f64,
    resolution_m: f64,
    width: u32,
    height: u32,
    state: &'static str,
    low_reliability_fraction: f64,
    counters: Counters,
    pass_ms: BTreeMap<&'a str, f64>,
}

#[derive(Serialize)]
pub(super) struct PoseRecord {
    translation_m: [f64; 3],
    rotation_xyzw: [f64; 4],
}

impl From<Rigid> for PoseRecord {
    fn from(rigid: Rigid) -> Self {
        Self { translation_m: rigid.translation_m.to_array(), rotation_xyzw: rigid.rotation.to_array() }
    }
}

impl<'a> FrameRecord<'a> {
    fn of(output: &'a FrameOutput) -> Self {
        let grid = output.grid;
        Self {
            stamp_ns: output.stamp_ns,
            map_from_base: output.map_from_base.into(),
            base_from_camera: output.base_from_camera.into(),
            origin_x_m: grid.origin_x_m,
            origin_y_m: grid.origin_y_m,
            resolution_m: grid.resolution_m,
            width: grid.width,
            height: grid.height,
            state: if output.degraded { "DEGRADED" } else { "OK" },
            low_reliability_fraction: output.low_reliability_fraction,
            counters: output.counters,
            pass_ms: pass_sums_ms(output).into_iter().collect(),
        }
    }
}
