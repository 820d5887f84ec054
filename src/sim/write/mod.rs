//! Simulated recordings as files: MCAP, or a TUM RGB-D folder, both with ground truth.

mod mcap;
mod packets;
mod tum;

use std::path::{Path, PathBuf};

pub use mcap::McapRecorder;
pub use tum::TumRecorder;

use super::frame::SimFrame;
use super::lidar::SimScan;
use super::scene::Scene;
use crate::base::{Error, Result, Rigid};
use crate::map::Grid;
use crate::output::End;

/// Takes simulated frames in their order.
pub trait Recorder {
    /// Appends a frame; `grid` and `cells` are the true map so far (see [`super::truth`]).
    ///
    /// # Errors
    /// [`crate::Error::File`] or [`crate::Error::Encode`], both with the path.
    fn write(&mut self, frame: &SimFrame, grid: &Grid, cells: &[i8]) -> Result<()>;

    /// Appends the robot's pose where there is no frame.
    ///
    /// # Errors
    /// As for writing, and [`crate::Error::Config`] where the recording takes frames alone.
    fn write_pose(&mut self, stamp_ns: u64, map_from_base: Rigid) -> Result<()> {
        let _ = (stamp_ns, map_from_base);
        Err(only_frames())
    }

    /// Appends a scan that ends at `end_ns`, with the truth of its points.
    ///
    /// # Errors
    /// As for [`Self::write_pose`].
    fn write_scan(&mut self, scan: &SimScan, end_ns: u64) -> Result<()> {
        let _ = (scan, end_ns);
        Err(only_frames())
    }

    /// Completes the recording.
    ///
    /// # Errors
    /// As for writing.
    fn finish(&mut self) -> Result<()>;

    /// Closes a recording that was not completed; the file that holds it, where it is not a folder.
    ///
    /// # Errors
    /// As for writing.
    fn abandon(&mut self, end: End) -> Result<Option<PathBuf>> {
        let _ = end;
        self.finish().map(|()| None)
    }
}

fn only_frames() -> Error {
    let reason = "a TUM folder holds images alone; write an MCAP file".into();
    Error::Config { key: "lidar".into(), reason }
}

/// Whether a recording of that name is an MCAP file.
pub fn is_mcap(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("mcap"))
}

/// An MCAP file where the name ends in `.mcap`, else a folder; `infrared`: with the two infrared images.
///
/// # Errors
/// [`crate::Error::File`] where it cannot be created.
pub fn recorder(path: &Path, scene: &Scene, infrared: bool) -> Result<Box<dyn Recorder>> {
    if is_mcap(path) {
        return Ok(Box::new(McapRecorder::create(path, scene, infrared)?));
    }
    if scene.lidar.is_some() {
        return Err(only_frames());
    }
    Ok(Box::new(TumRecorder::create(path, scene, infrared)?))
}
