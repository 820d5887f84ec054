//! Which reader of scans a path is for, by its content.

use std::path::Path;

use crate::base::Result;
use crate::input::log::LogFiles;
use crate::input::open::unread;
use crate::input::points::{FileScans, LogScans, Options, PcapScans, Scans, capture, pcd, ply};
use crate::input::start::start_of;

const SUPPORTED: &str = "MCAP files, ROS 1 bags, rosbag2 folders and .db3 files, pcap and pcapng files of Velodyne sensors, PLY and PCD files and folders of these are read";

/// Opens a recording of lidar scans: an MCAP file, a ROS 1 bag, a rosbag2 folder, a pcap or pcapng file, a PLY or PCD file,
/// or a folder of these two.
///
/// # Errors
/// [`crate::Error::File`]; [`crate::Error::Format`] for anything else, with what it looks like; what [`LogScans::mcap`],
/// [`PcapScans::open`] and [`FileScans::folder`] return.
pub fn open(path: &Path, options: &Options) -> Result<Box<dyn Scans>> {
    if let Some(files) = LogFiles::find(path)? {
        return Ok(Box::new(LogScans::of(files, options)?));
    }
    if path.is_dir() {
        return Ok(Box::new(FileScans::folder(path, options)?));
    }
    let start = start_of(path)?;
    let begins = |magics: &[&[u8]]| magics.iter().any(|magic| start.starts_with(magic));
    let named_pcd = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("pcd"));
    if begins(&capture::MAGICS) {
        Ok(Box::new(PcapScans::open(path, options)?))
    } else if begins(&[ply::MAGIC]) || begins(&pcd::MAGICS) || named_pcd && !start.is_empty() {
        Ok(Box::new(FileScans::file(path, options)))
    } else {
        Err(unread(path, &start, SUPPORTED))
    }
}
