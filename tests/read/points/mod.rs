//! Lidar scans: hand-computed values, other programs' figures, bad and hostile input.

mod cloud;
mod cloud_bad;
mod command;
mod endless;
mod files;
mod hostile;
mod laser;
mod make;
mod model;
mod pcapng;
mod real;
mod times;
mod velodyne;

use std::path::Path;

use limpid::input::points::{Options, ScanReport, open};
use limpid::sensor::Scan;

/// All scans of a recording, and what its reader reported.
fn read_all(path: &Path, options: &Options) -> limpid::Result<(Vec<Scan>, ScanReport)> {
    let mut reader = open(path, options)?;
    let mut scans = Vec::new();
    while let Some(scan) = reader.next_scan()? {
        scans.push(scan);
    }
    Ok((scans, reader.report().clone()))
}

/// As [`read_all`], of bytes in a file of that name.
fn read_bytes(name: &str, bytes: &[u8]) -> limpid::Result<(Vec<Scan>, ScanReport)> {
    read_with(name, bytes, &Options::default())
}

fn read_with(name: &str, bytes: &[u8], options: &Options) -> limpid::Result<(Vec<Scan>, ScanReport)> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read_all(&path, options)
}

/// Asserts that the error's text has all the parts.
#[track_caller]
fn refused<T: std::fmt::Debug>(result: limpid::Result<T>, parts: &[&str]) {
    let text = result.unwrap_err().to_string();
    assert!(parts.iter().all(|part| text.contains(part)), "{text}");
}
