//! PLY and PCD files, one or a folder of them: a scan a file.

use std::io::Read;
use std::path::{Path, PathBuf};

use crate::base::{Error, Result};
use crate::input::points::{Options, ScanReport, Scans, check_reach, pcd, ply};
use crate::input::start::open_file;
use crate::sensor::Scan;

/// Largest file that is read, bytes.
const MAX_FILE_BYTES: u64 = 1 << 30;

/// Times in file names are later than 1973.
const LEAST_EPOCH_S: u64 = 100_000_000;

/// Reads one file, or those of a folder in order of their names; see [`Scans`]. The stamp is that of a PLY file's
/// comment `stamp_ns`, else the time in seconds that the file's name is, if it is one, else the earliest time since 1970 of
/// its points, else 0.
pub struct FileScans {
    files: Vec<PathBuf>,
    next: usize,
    options: Options,
    report: ScanReport,
}

impl FileScans {
    /// One file.
    pub fn file(path: &Path, options: &Options) -> Self {
        Self { files: vec![path.into()], next: 0, options: options.clone(), report: ScanReport::default() }
    }

    /// The `.ply` and `.pcd` files in a folder; other files are passed over.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Format`] where there are none.
    pub fn folder(path: &Path, options: &Options) -> Result<Self> {
        let entries = std::fs::read_dir(path).map_err(Error::file(path))?;
        let entries = entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<Vec<_>, _>>();
        let mut files = entries.map_err(Error::file(path))?;
        files.retain(|file| ["ply", "pcd"].iter().any(|kind| file.extension().is_some_and(|e| e == *kind)));
        if files.is_empty() {
            let reason = "is a folder without .ply and .pcd files".into();
            return Err(Error::Format { path: path.into(), reason });
        }
        files.sort();
        Ok(Self { files, ..Self::file(path, options) })
    }

    fn read(&self, path: &Path) -> Result<Scan> {
        let mut bytes = Vec::new();
        let file = open_file(path)?;
        file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(Error::file(path))?;
        if bytes.len() as u64 > MAX_FILE_BYTES {
            return Err(Error::Format { path: path.into(), reason: "is larger than 1 GiB".into() });
        }
        let stamp_ns = stamp_in_name(path).unwrap_or(0);
        let read = if bytes.starts_with(ply::MAGIC) {
            ply::read(&bytes, stamp_ns, &self.options)
        } else {
            pcd::read(&bytes, stamp_ns, &self.options)
        };
        let near = read.and_then(|scan| check_reach("scan", &scan).map(|()| scan));
        near.map_err(|error| Error::Format { path: path.into(), reason: error.to_string() })
    }
}

/// Nanoseconds since the Unix epoch of a file named by its time in seconds, such as `1689496219.652560.ply`.
fn stamp_in_name(path: &Path) -> Option<u64> {
    let (seconds, fraction) = path.file_stem()?.to_str()?.split_once('.')?;
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    if !digits(seconds) || !digits(fraction) {
        return None;
    }
    let nanoseconds: u64 = format!("{fraction:0<9}").get(..9)?.parse().ok()?;
    let seconds = seconds.parse::<u64>().ok().filter(|&seconds| seconds >= LEAST_EPOCH_S)?;
    seconds.checked_mul(1_000_000_000)?.checked_add(nanoseconds)
}

impl Scans for FileScans {
    fn next_scan(&mut self) -> Result<Option<Scan>> {
        while let Some(path) = self.files.get(self.next).cloned() {
            self.next += 1;
            let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
            match self.read(&path) {
                Ok(mut scan) if !scan.points.is_empty() => {
                    self.report.count(&mut scan);
                    return Ok(Some(scan));
                }
                Ok(scan) => self.report.count_empty(&name, &scan),
                Err(error) if self.files.len() == 1 => return Err(error),
                Err(error) => self.report.read.skip(&name, error.to_string(), 0),
            }
        }
        Ok(None)
    }

    fn report(&self) -> &ScanReport {
        &self.report
    }

    fn scan_count_hint(&self) -> Option<u64> {
        Some(self.files.len() as u64)
    }
}
