//! A packed SQLite file (`.db3.zstd`), unpacked into a temporary one, as SQLite reads here and there in it.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

use tempfile::TempPath;

use crate::base::{Error, Result};
use crate::input::db3::MAGIC;
use crate::input::db3::database::{HEADER, bytes_of};
use crate::input::start::open_file;

/// Largest SQLite file that can be (2^32 - 2 pages of 64 KiB), bytes.
const MOST_BYTES: u64 = 1 << 48;

/// See the module; the file is removed with it.
#[derive(Debug)]
pub(in crate::input) struct Unpacked(TempPath);

impl Unpacked {
    /// # Errors
    /// [`Error::File`] where the file cannot be read or the temporary one cannot be written; [`Error::Format`] for files that
    /// are not packed SQLite. Of a file that is cut off or damaged what comes before is kept.
    pub(in crate::input) fn of(path: &Path) -> Result<Self> {
        let damaged = |reason: &str| Error::Format { path: path.into(), reason: reason.into() };
        let file = BufReader::with_capacity(1 << 16, open_file(path)?);
        let mut packed = zstd::Decoder::with_buffer(file).map_err(Error::file(path))?;
        let mut header = [0; HEADER];
        if packed.read_exact(&mut header).is_err() || !header.starts_with(MAGIC) {
            return Err(damaged("is packed with zstd and holds no whole header of an SQLite file"));
        }
        let mut unpacked = tempfile::Builder::new()
            .prefix("limpid-")
            .suffix(".db3")
            .tempfile()
            .map_err(Error::file(std::env::temp_dir()))?;
        let most = bytes_of(header).unwrap_or(MOST_BYTES);
        // What is packed behind the pages is no part of the database.
        copy(&mut (&header[..]).chain(packed).take(most), unpacked.as_file_mut())
            .map_err(Error::file(unpacked.path()))?;
        Ok(Self(unpacked.into_temp_path()))
    }

    pub(in crate::input) fn path(&self) -> &Path {
        &self.0
    }
}

/// Copies to the end of what can be unpacked; errors are those of writing.
fn copy(packed: &mut impl Read, to: &mut File) -> io::Result<()> {
    let mut piece = vec![0; 1 << 16];
    loop {
        let read = packed.read(&mut piece).unwrap_or(0);
        if read == 0 {
            return Ok(());
        }
        io::Write::write_all(to, &piece[..read])?;
    }
}
