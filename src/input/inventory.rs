//! What a recording holds, before anything is made of it.

use std::path::Path;

use serde::Serialize;

use crate::base::{Error, Result};
use crate::config::Config;
use crate::input::log;
use crate::input::open::log_files;

/// Topics, frames and times of a recording.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Inventory {
    /// What kind of recording it is, in words.
    pub format: String,
    /// Bytes of the file, or of all files of a folder.
    pub size_bytes: u64,
    /// Log times of the first and the last message, nanoseconds; `None` where they are not known.
    pub span_ns: Option<[u64; 2]>,
    /// Topics by name; none of a recording that has no topics.
    pub topics: Vec<TopicInfo>,
    /// Frames that transforms were seen of, by name.
    pub frames: Vec<FrameInfo>,
    /// The trees of frames, in a line; empty where there are none.
    pub frame_tree: String,
    /// Damage that was met, and how far the recording was looked through.
    pub notes: Vec<String>,
}

/// A topic.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TopicInfo {
    /// Its name.
    pub topic: String,
    /// Message type and encoding.
    pub type_name: String,
    /// Messages; `None` where they were not counted.
    pub messages: Option<u64>,
    /// Messages a second; `None` for fewer than two.
    pub rate_hz: Option<f64>,
    /// Whether its type is one that is read.
    pub is_read: bool,
}

/// A frame and its transform.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FrameInfo {
    /// The frame.
    pub frame: String,
    /// Its parent.
    pub parent: String,
    /// Whether the transform holds for all time (`/tf_static`).
    pub fixed: bool,
}

impl Inventory {
    /// Looks through a recording. What has an index is not read whole: of its transforms the first 64 MiB are.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Format`] for a log of messages that is damaged from its start on.
    pub fn of(path: &Path, config: &Config) -> Result<Self> {
        let size_bytes = size_of(path)?;
        let inventory = match log_files(path, config)? {
            Some(files) => log::inventory(files)?,
            None => Self { format: format_of(path, config).into(), ..Self::default() },
        };
        Ok(Self { size_bytes, ..inventory })
    }

    /// Seconds from the first to the last message.
    pub fn duration_s(&self) -> Option<f64> {
        let [first_ns, last_ns] = self.span_ns?;
        Some(crate::base::seconds_between(first_ns, last_ns))
    }
}

/// What a path that is no log of messages is.
fn format_of(path: &Path, config: &Config) -> &'static str {
    let ends_in = |extension: &str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension));
    match path.is_dir() {
        true if !config.depth_file.is_empty() => "folder with a still pair",
        true if path.join("depth.txt").exists() => "TUM RGB-D folder",
        true => "folder",
        false if ends_in("pcap") || ends_in("pcapng") => "packet capture",
        false if ends_in("ply") => "PLY file",
        false if ends_in("pcd") => "PCD file",
        false => "file",
    }
}

/// Bytes of a file, or of the files in a folder and its folders.
fn size_of(path: &Path) -> Result<u64> {
    let about = std::fs::metadata(path).map_err(Error::file(path))?;
    if !about.is_dir() {
        return Ok(about.len());
    }
    let (mut folders, mut bytes) = (vec![path.to_owned()], 0);
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).map_err(Error::file(&folder))?.flatten() {
            match entry.metadata() {
                Ok(about) if about.is_dir() => folders.push(entry.path()),
                Ok(about) => bytes += about.len(),
                Err(_) => {}
            }
        }
    }
    Ok(bytes)
}
