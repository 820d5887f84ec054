//! Which reader of scans a path is for, by its content.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::base::{Error, Result};
use crate::input::bag;
use crate::input::open::unread;
use crate::input::points::{FileScans, LogScans, Options, PcapScans, Scans, pcap, pcd, ply};

const SUPPORTED: &str =
    "MCAP files, ROS 1 bags, pcap files of Velodyne sensors, PLY and PCD files and folders of these are read";

/// Opens a recording of lidar scans: an MCAP file, a ROS 1 bag, a pcap file, a PLY or PCD file, or a folder of these two.
///
/// # Errors
/// [`Error::File`]; [`Error::Format`] for anything else, with what it looks like; what [`LogScans::mcap`],
/// [`PcapScans::open`] and [`FileScans::folder`] return.
pub fn open(path: &Path, options: &Options) -> Result<Box<dyn Scans>> {
    if path.is_dir() {
        return Ok(Box::new(FileScans::folder(path, options)?));
    }
    let mut start = Vec::new();
    let file = File::open(path).map_err(Error::file(path))?;
    file.take(16).read_to_end(&mut start).map_err(Error::file(path))?;
    let begins = |magics: &[&[u8]]| magics.iter().any(|magic| start.starts_with(magic));
    let named_pcd = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("pcd"));
    if begins(&[::mcap::MAGIC]) {
        Ok(Box::new(LogScans::mcap(path, options)?))
    } else if begins(&[bag::MAGIC]) {
        Ok(Box::new(LogScans::bag(path, options)?))
    } else if begins(&pcap::MAGICS) {
        Ok(Box::new(PcapScans::open(path, options)?))
    } else if begins(&[ply::MAGIC]) || begins(&pcd::MAGICS) || named_pcd && !start.is_empty() {
        Ok(Box::new(FileScans::file(path, options)))
    } else {
        Err(unread(path, &start, SUPPORTED))
    }
}
