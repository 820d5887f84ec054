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

/// What is unpacked at most: so many times the packed bytes, and never less than a gibibyte.
const MOST_TIMES: u64 = 1000;
const ALWAYS_BYTES: u64 = 1 << 30;

/// Bytes that a packed file may hold.
fn most_of(packed_bytes: u64) -> u64 {
    packed_bytes.saturating_mul(MOST_TIMES).max(ALWAYS_BYTES)
}

/// See the module; the file is removed with it.
#[derive(Debug)]
pub(in crate::input) struct Unpacked(TempPath);

impl Unpacked {
    /// # Errors
    /// [`Error::File`] where the file cannot be read or the temporary one cannot be written; [`Error::Format`] for files that
    /// are not packed SQLite, or hold more than a thousand times their own bytes. Of a file that is cut off or damaged what comes
    /// before is kept.
    pub(in crate::input) fn of(path: &Path) -> Result<Self> {
        let bytes = std::fs::metadata(path).map_err(Error::file(path))?.len();
        Self::of_at_most(path, most_of(bytes))
    }

    fn of_at_most(path: &Path, most: u64) -> Result<Self> {
        let damaged = |reason: &str| Error::Format { path: path.into(), reason: reason.into() };
        let file = BufReader::with_capacity(1 << 16, open_file(path)?);
        let mut packed = zstd::Decoder::with_buffer(file).map_err(Error::file(path))?;
        let mut header = [0; HEADER];
        if packed.read_exact(&mut header).is_err() || !header.starts_with(MAGIC) {
            return Err(damaged("is packed with zstd and holds no whole header of an SQLite file"));
        }
        let said = bytes_of(header).unwrap_or(MOST_BYTES);
        let mut unpacked = tempfile::Builder::new()
            .prefix("limpid-")
            .suffix(".db3")
            .tempfile()
            .map_err(Error::file(std::env::temp_dir()))?;
        // What is packed behind the pages is no part of the database.
        let copied = copy(&mut (&header[..]).chain(packed).take(said.min(most)), unpacked.as_file_mut())
            .map_err(Error::file(unpacked.path()))?;
        if copied == most && said > most {
            return Err(damaged(&format!(
                "holds more than {most} bytes, more than is believed of its size: unpack it with `unzstd`"
            )));
        }
        Ok(Self(unpacked.into_temp_path()))
    }

    pub(in crate::input) fn path(&self) -> &Path {
        &self.0
    }
}

/// Copies to the end of what can be unpacked, and gives the bytes; errors are those of writing.
fn copy(packed: &mut impl Read, to: &mut File) -> io::Result<u64> {
    let mut piece = vec![0; 1 << 16];
    let mut copied = 0;
    loop {
        let read = packed.read(&mut piece).unwrap_or(0);
        if read == 0 {
            return Ok(copied);
        }
        copied += read as u64;
        io::Write::write_all(to, &piece[..read])?;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_packed_file_may_hold_goes_by_its_size() {
        assert_eq!(most_of(44_000), ALWAYS_BYTES);
        assert_eq!(most_of(10 << 20), 10_000 << 20);
        assert_eq!(most_of(u64::MAX), u64::MAX);
    }

    #[test]
    fn no_more_is_unpacked_than_is_believed() {
        // A header that says 2^31 pages of 64 KiB, and zeros.
        let mut database = vec![0_u8; 100_000];
        database[..MAGIC.len()].copy_from_slice(MAGIC);
        database[16..18].copy_from_slice(&1_u16.to_be_bytes());
        database[28..32].copy_from_slice(&(1_u32 << 31).to_be_bytes());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bomb.db3.zstd");
        std::fs::write(&path, zstd::encode_all(&database[..], 3).unwrap()).unwrap();
        let said = Unpacked::of_at_most(&path, 65_536).unwrap_err().to_string();
        assert!(said.contains("more than 65536 bytes"), "{said}");
        // Cut off it is another matter: what is there is kept.
        let kept = Unpacked::of_at_most(&path, 200_000).unwrap();
        assert_eq!(std::fs::metadata(kept.path()).unwrap().len(), 100_000);
    }
}
