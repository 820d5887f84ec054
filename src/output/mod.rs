//! Writers: MCAP, pictures, EXR dumps and map_server files.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use crate::base::{Error, Result};
use crate::frame::FrameOutput;
use crate::sensor::RgbdFrame;

pub mod cloud;
mod diagnostics;
mod exr;
mod glass;
mod map_server;
mod mcap;
mod ply;
pub(crate) mod png;
mod ros_file;
mod scan_exr;
mod scan_mcap;

pub use exr::DumpSink;
pub(crate) use exr::write_exr;
pub use map_server::{save_map, save_plan};
pub use mcap::{McapSink, occupancy_of_cost};
pub use ply::save_scan;
pub use png::{PngSink, ScanPngSink};
pub use ros_file::RosFile;
pub use scan_exr::ScanDumpSink;
pub use scan_mcap::ScanMcapSink;

/// Something that takes the results of a run, frame by frame: those of RGB-D frames, or with other types of scans.
pub trait Sink<Input = RgbdFrame, Output = FrameOutput> {
    /// Writes what `output` holds for the frame `input`.
    ///
    /// # Errors
    /// [`Error::File`] or [`Error::Encode`], both with the path.
    fn write(&mut self, input: &Input, output: &Output) -> Result<()>;

    /// Completes and closes what was written; writing afterwards is an error.
    ///
    /// # Errors
    /// [`Error::File`] or [`Error::Encode`], both with the path.
    fn finish(&mut self) -> Result<()>;
}

/// Milliseconds by pass in order of first appearance; a pass that runs more than once is summed.
fn pass_sums_ms(output: &FrameOutput) -> Vec<(&str, f64)> {
    let mut sums: Vec<(&str, f64)> = Vec::new();
    for (pass, ms) in &output.pass_ms {
        match sums.iter_mut().find(|(name, _)| name == pass) {
            Some((_, sum)) => *sum += ms,
            None => sums.push((pass, *ms)),
        }
    }
    sums
}

/// How the grid's cells and the costs disagree, if they do.
fn grid_mismatch(output: &FrameOutput) -> Option<String> {
    let (width, height, costs) = (output.grid.width, output.grid.height, output.costmap.len());
    let fits = costs > 0 && costs == width as usize * height as usize;
    (!fits).then(|| format!("{costs} costs do not fill a grid of {width}x{height} cells"))
}

pub(crate) fn create_file(path: &Path) -> Result<BufWriter<File>> {
    File::create(path).map(BufWriter::new).map_err(Error::file(path))
}

/// Makes `path` a folder; its parent must exist, so that a mistyped path is found out.
pub(crate) fn create_folder(path: &Path) -> Result<()> {
    match std::fs::create_dir(path) {
        Err(_) if path.is_dir() => Ok(()),
        result => result.map_err(Error::file(path)),
    }
}

/// An [`Error::Encode`] for `path`.
pub(crate) fn encode_error(path: &Path, reason: impl ToString) -> Error {
    Error::Encode { path: path.into(), reason: reason.to_string() }
}

#[expect(clippy::cast_possible_truncation, reason = "narrowed on purpose: the format has 32-bit floats")]
fn narrow(value: f64) -> f32 {
    value as f32
}
