//! Writers: MCAP, pictures, EXR dumps and map_server files.

use std::path::{Path, PathBuf};

use crate::base::{Error, Result};
use crate::config::SensorInfo;
use crate::map::{MapUpdate, Update};
use crate::sensor::Observation;

pub mod cloud;
mod exr;
mod map_server;
mod mcap;
mod ply;
pub(crate) mod png;
mod ros_file;
mod staged;
pub(crate) mod topics;

pub use exr::DumpSink;
pub(crate) use exr::write_exr;
pub use map_server::{map_files, save_map};
pub use mcap::McapSink;
pub use ply::save_scan;
pub use png::PngSink;
pub use ros_file::RosFile;
pub(crate) use ros_file::abandon;
pub(crate) use staged::{StagedFile, save_in_folder, save_pair};
pub use staged::{free_path, save_file};
pub use topics::occupancy_of_cost;

/// Something that takes the results of a run, one after the other.
///
/// ```
/// use limpid::{Observation, Result, Sink, Update};
///
/// /// Counts lethal cells of every map.
/// #[derive(Default)]
/// struct Lethal(Vec<usize>);
///
/// impl Sink for Lethal {
///     fn write(&mut self, update: &Update, _observation: Option<&Observation>) -> Result<()> {
///         let maps = update.map.iter();
///         self.0.extend(maps.map(|map| map.costmap.iter().filter(|&&cost| cost == 254).count()));
///         Ok(())
///     }
///     fn finish(&mut self) -> Result<()> {
///         Ok(())
///     }
/// }
///
/// let sinks: Vec<Box<dyn Sink>> = vec![Box::new(Lethal::default())];
/// # assert_eq!(sinks.len(), 1);
/// ```
pub trait Sink {
    /// Writes what `update` holds; `observation` is what it came of, `None` for a published map alone.
    ///
    /// # Errors
    /// [`Error::File`] or [`Error::Encode`], both with the path.
    fn write(&mut self, update: &Update, observation: Option<&Observation>) -> Result<()>;

    /// Completes and closes what was written; writing afterwards is an error.
    ///
    /// # Errors
    /// [`Error::File`] or [`Error::Encode`], both with the path.
    fn finish(&mut self) -> Result<()>;

    /// Closes what was written by a run that did not come to its end: it failed, or was stopped by its user. Gives the file
    /// that holds what was written, where it is not complete; `None` for what is complete piece by piece, and where nothing
    /// was written.
    ///
    /// # Errors
    /// As [`Sink::finish`].
    fn abandon(&mut self, end: End) -> Result<Option<PathBuf>> {
        let _ = end;
        self.finish().map(|()| None)
    }
}

/// How a run ended before its recording did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// By an error.
    Failed,
    /// As its user wanted.
    Stopped,
}

/// Names that tell the sensors of a map apart in the paths of files; the map has its own, `map`.
struct FileNames(Vec<String>);

impl FileNames {
    /// None where there is one sensor alone.
    fn of(sensors: &[SensorInfo]) -> Self {
        let several = sensors.len() > 1;
        Self(sensors.iter().filter(|_| several).map(|sensor| sensor.name.clone()).collect())
    }

    /// That of the sensor that an update came of; empty: it needs none.
    fn sensor(&self, update: &Update) -> &str {
        update.sensor.and_then(|sensor| self.0.get(sensor)).map_or("", String::as_str)
    }

    /// That of the map; empty: it needs none.
    fn map(&self) -> &'static str {
        if self.0.is_empty() { "" } else { "map" }
    }
}

/// Whether a sensor is one of several cameras, or of several lidars.
fn one_of_several(sensors: &[SensorInfo], sensor: &SensorInfo) -> bool {
    let alike = |other: &&SensorInfo| other.model.kind() == sensor.model.kind();
    sensors.iter().filter(alike).count() > 1
}

/// Milliseconds by pass in order of first appearance; a pass that runs more than once is summed.
fn pass_sums_ms(update: &Update) -> Vec<(&str, f64)> {
    let mut sums: Vec<(&str, f64)> = Vec::new();
    for (pass, ms) in &update.pass_ms {
        match sums.iter_mut().find(|(name, _)| *name == &**pass) {
            Some((_, sum)) => *sum += ms,
            None => sums.push((pass, *ms)),
        }
    }
    sums
}

/// How the grid's cells and what is said of them disagree, if they do.
fn grid_mismatch(map: &MapUpdate) -> Option<String> {
    let (width, height, costs) = (map.grid.width, map.grid.height, map.costmap.len());
    if costs == 0 || costs != width as usize * height as usize {
        return Some(format!("{costs} costs do not fill a grid of {width}x{height} cells"));
    }
    let others = [("classes", map.classes.len()), ("verdicts", map.verdicts.len())];
    let other = others.into_iter().find(|(_, count)| *count != 0 && *count != costs)?;
    Some(format!("{costs} costs and {} {} do not fill the grid", other.1, other.0))
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
