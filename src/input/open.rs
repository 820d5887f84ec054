//! Which reader a path is for, by its content.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::base::{Error, Result};
use crate::config::Config;
use crate::input::points;
use crate::input::points::FileScans;
use crate::input::{Contents, LogReader, Recording, StillReader, TumReader, bag, log};

/// What a recording holds: depth images, lidar scans, or both; neither where it is of no known format, or damaged: then
/// [`open`] says what is wrong.
///
/// # Errors
/// [`Error::File`].
pub fn contents(path: &Path, config: &Config) -> Result<Contents> {
    if path.is_dir() {
        let camera = !config.depth_file.is_empty() || path.join("depth.txt").exists();
        return Ok(Contents {
            camera,
            lidar: !camera && FileScans::folder(path, &Default::default()).is_ok(),
        });
    }
    let mut start = Vec::new();
    let file = File::open(path).map_err(Error::file(path))?;
    file.take(16).read_to_end(&mut start).map_err(Error::file(path))?;
    let is_bag = start.starts_with(bag::MAGIC);
    if is_bag || start.starts_with(::mcap::MAGIC) {
        // What is wrong with the file is for its reader to say.
        return Ok(log::contents(path, is_bag).unwrap_or(Contents { camera: true, lidar: false }));
    }
    Ok(Contents { camera: false, lidar: points::open(path, &Default::default()).is_ok() })
}

const SUPPORTED: &str = "MCAP files, ROS 1 bags, TUM RGB-D folders (depth.txt, camera.yaml) and still pairs (`depth_file` in the configuration) are read";

/// Opens a recording: an MCAP file, a ROS 1 bag, a TUM RGB-D folder, or, where `depth_file` is configured, a folder
/// with a still pair.
///
/// # Errors
/// [`Error::Format`] for anything else, with what it looks like and how to convert it; what
/// [`LogReader::mcap`], [`LogReader::bag`], [`TumReader::open`] and [`StillReader::open`] return.
pub fn open(path: &Path, config: &Config) -> Result<Box<dyn Recording>> {
    if path.is_dir() {
        return open_folder(path, config);
    }
    let mut start = Vec::new();
    let file = File::open(path).map_err(Error::file(path))?;
    file.take(16).read_to_end(&mut start).map_err(Error::file(path))?;
    if start.starts_with(::mcap::MAGIC) {
        return Ok(Box::new(LogReader::mcap(path, config)?));
    }
    if start.starts_with(bag::MAGIC) {
        return Ok(Box::new(LogReader::bag(path, config)?));
    }
    Err(unread(path, &start, SUPPORTED))
}

/// First bytes of a pcapng file.
const PCAPNG_MAGIC: &[u8] = &[0x0a, 0x0d, 0x0d, 0x0a];

/// The error for a file that begins with `start` and that nobody reads: what it looks like, and what is `supported`.
pub(in crate::input) fn unread(path: &Path, start: &[u8], supported: &str) -> Error {
    let looks = if start.starts_with(b"#ROSBAG V") {
        "is a ROS 1 bag of a format other than 2.0"
    } else if start.starts_with(b"SQLite format 3") {
        "is an SQLite file, as rosbag2 wrote them (.db3): convert it with `ros2 bag convert` or `mcap convert`"
    } else if start.starts_with(PCAPNG_MAGIC) {
        "is a pcapng file: convert it with `editcap -F pcap`"
    } else if start.is_empty() {
        "is empty"
    } else {
        "is of no known format"
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
    let reason = if path.join("metadata.yaml").exists() {
        format!("is a rosbag2 folder: give the .mcap file in it; {SUPPORTED}")
    } else {
        format!("is a folder without depth.txt; {SUPPORTED}")
    };
    Err(Error::Format { path: path.into(), reason })
}
