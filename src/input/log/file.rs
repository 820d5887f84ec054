//! A file that is read from front to back, and where in it the reader is.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use crate::base::{Error, Result};

/// See the module.
pub(crate) struct LogFile {
    file: BufReader<File>,
    path: PathBuf,
    size: u64,
    offset: u64,
}

impl LogFile {
    /// Opens a file that starts with `magic`; `name` is what it then is.
    ///
    /// # Errors
    /// [`Error::File`], and [`Error::Format`] for other files.
    pub(crate) fn open(path: &Path, magic: &[u8], name: &str) -> Result<Self> {
        let file = File::open(path).map_err(Error::file(path))?;
        let size = file.metadata().map_err(Error::file(path))?.len();
        let file = BufReader::with_capacity(1 << 16, file);
        let mut log = Self { file, path: path.into(), size, offset: 0 };
        if log.take_bytes(magic.len() as u64)? != magic {
            return Err(Error::Format { path: path.into(), reason: format!("is not {name}") });
        }
        Ok(log)
    }

    pub(crate) fn size(&self) -> u64 {
        self.size
    }

    /// Bytes gone through so far.
    pub(crate) fn offset(&self) -> u64 {
        self.offset
    }

    /// Bytes still to come.
    pub(crate) fn left(&self) -> u64 {
        self.size.saturating_sub(self.offset)
    }

    /// Goes on at byte `to`.
    pub(crate) fn seek(&mut self, to: u64) -> Result<()> {
        #[expect(clippy::cast_possible_wrap, reason = "the difference wraps back to the signed step")]
        let step = to.wrapping_sub(self.offset) as i64;
        self.file.seek_relative(step).map_err(Error::file(&self.path))?;
        self.offset = to;
        Ok(())
    }

    /// The next bytes, fewer than `length` where the file ends.
    pub(crate) fn take_bytes(&mut self, length: u64) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        (&mut self.file).take(length).read_to_end(&mut bytes).map_err(Error::file(&self.path))?;
        self.offset += bytes.len() as u64;
        Ok(bytes)
    }

    /// What to tell of a file that cannot be read on from byte `at`.
    pub(crate) fn end_note(&self, at: u64, what: &str) -> String {
        format!(
            "the file is cut off or damaged: it ends at byte {} and has {what} at byte {at}; what comes before was read",
            self.size
        )
    }
}

impl Read for LogFile {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read(bytes)?;
        self.offset += read as u64;
        Ok(read)
    }
}
