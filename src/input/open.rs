//! Which reader a path is for, by its content.

use std::path::Path;

use crate::base::{Error, Result};
use crate::config::Config;
use crate::input::log::LogFiles;
use crate::input::points;
use crate::input::points::FileScans;
use crate::input::start::start_of;
use crate::input::{Contents, LogReader, Recording, StillReader, TumReader, log};

/// What a recording holds: depth images, lidar scans, or both; neither where it is of no known format, or damaged: then
/// [`open`] says what is wrong.
///
/// # Errors
/// [`Error::File`]; [`Error::Format`] for what cannot be read as a file, and for folders of several recordings.
pub fn contents(path: &Path, config: &Config) -> Result<Contents> {
    if let Some(files) = log_files(path, config)? {
        // What is wrong with the files is for their reader to say.
        return Ok(log::contents(&files).unwrap_or(Contents { camera: true, lidar: false }));
    }
    if path.is_dir() {
        let camera = has_images(path, config);
        return Ok(Contents {
            camera,
            lidar: !camera && FileScans::folder(path, &Default::default()).is_ok(),
        });
    }
    Ok(Contents { camera: false, lidar: points::open(path, &Default::default()).is_ok() })
}

const SUPPORTED: &str = "MCAP files, ROS 1 bags, TUM RGB-D folders (depth.txt, camera.yaml), rosbag2 folders and .db3 files and still pairs (`depth_file` in the configuration) are read";

/// Opens a recording: an MCAP file, a ROS 1 bag, a rosbag2 folder, a TUM RGB-D folder, or, where `depth_file` is
/// configured, a folder with a still pair.
///
/// # Errors
/// [`Error::Format`] for anything else, with what it looks like and how to convert it; what
/// [`LogReader::mcap`], [`LogReader::bag`], [`TumReader::open`] and [`StillReader::open`] return.
pub fn open(path: &Path, config: &Config) -> Result<Box<dyn Recording>> {
    if let Some(files) = log_files(path, config)? {
        return Ok(Box::new(LogReader::of(files, config)?));
    }
    if path.is_dir() {
        return open_folder(path, config);
    }
    Err(unread(path, &start_of(path)?, SUPPORTED))
}

/// The files of a recording of messages; `None` for others, which a folder of images is, whatever else lies in it.
///
/// # Errors
/// What [`LogFiles::find`] returns.
pub(in crate::input) fn log_files(path: &Path, config: &Config) -> Result<Option<LogFiles>> {
    if path.is_dir() && has_images(path, config) { Ok(None) } else { LogFiles::find(path) }
}

fn has_images(folder: &Path, config: &Config) -> bool {
    !config.depth_file.is_empty() || folder.join("depth.txt").exists()
}

/// What the first bytes of files that nobody reads say of them.
const KNOWN: [(&[u8], &str); 8] = [
    (b"#ROSBAG V", "is a ROS 1 bag of a format other than 2.0"),
    (&[0x1f, 0x8b], "is packed with gzip: unpack it with `gunzip`"),
    (b"BZh", "is packed with bzip2: unpack it with `bunzip2`"),
    (&[0xfd, b'7', b'z', b'X', b'Z', 0], "is packed with xz: unpack it with `unxz`"),
    (b"PK\x03\x04", "is a zip archive: unpack it with `unzip`"),
    (&[b'7', b'z', 0xbc, 0xaf, 0x27, 0x1c], "is a 7-Zip archive: unpack it with `7z x`"),
    (b"version https://git-lfs", "is a pointer of Git LFS and not the file: get that with `git lfs pull`"),
    (b"RRF", "is a recording of Rerun"),
];

/// The error for a file that begins with `start` and that nobody reads: what it looks like, and what is `supported`.
pub(in crate::input) fn unread(path: &Path, start: &[u8], supported: &str) -> Error {
    let known = KNOWN.iter().find(|(magic, _)| start.starts_with(&magic[..magic.len().min(16)]));
    let looks = match known {
        Some((_, looks)) => looks,
        None if start.is_empty() => "is empty",
        None => "is of no known format",
    };
    Error::Format { path: path.into(), reason: format!("{looks}; {supported}") }
}

fn open_folder(path: &Path, config: &Config) -> Result<Box<dyn Recording>> {
    if !config.depth_file.is_empty() {
        return Ok(Box::new(StillReader::open(path, config)?));
    }
    if path.join("depth.txt").exists() {
        return Ok(Box::new(TumReader::open(path, config)?));
    }
    let below = recordings_below(path);
    let reason = if below.is_empty() {
        format!("is a folder without depth.txt and without bags; {SUPPORTED}")
    } else {
        format!(
            "is a folder without a recording of its own, but there are {}: give one of them",
            below.join(", ")
        )
    };
    Err(Error::Format { path: path.into(), reason })
}

/// Folders in a folder that look like recordings.
fn recordings_below(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_one = |path: &Path| path.join("metadata.yaml").exists() || path.join("depth.txt").exists();
    let mut names: Vec<String> = entries
        .map(|entry| entry.path())
        .filter(|path| path.is_dir() && is_one(path))
        .map(|path| path.display().to_string())
        .collect();
    names.sort();
    names.truncate(8);
    names
}
