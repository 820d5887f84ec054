//! A file that is read from front to back, and where in it the reader is. A file that is packed with zstd as a whole
//! (`.mcap.zstd`) is unpacked as it is read.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::{Path, PathBuf};

use crate::base::{Error, Result};
use crate::input::start::{open_file, start_of};
use crate::input::zstd_frame;

/// Bytes read or unpacked at a time.
const BUFFER_BYTES: usize = 1 << 16;

enum Bytes {
    Plain {
        file: BufReader<File>,
        size: u64,
    },
    /// Bytes are counted as they are unpacked.
    Packed(Box<BufReader<zstd::Decoder<'static, BufReader<File>>>>),
}

/// See the module.
pub(crate) struct LogFile {
    bytes: Bytes,
    path: PathBuf,
    offset: u64,
    /// Why what is packed cannot be unpacked further.
    fault: Option<String>,
}

impl LogFile {
    /// Opens a file that starts with `magic`; `name` is what it then is.
    ///
    /// # Errors
    /// [`Error::File`], and [`Error::Format`] for other files.
    pub(crate) fn open(path: &Path, magic: &[u8], name: &str) -> Result<Self> {
        let packed = start_of(path)?.starts_with(&zstd_frame::MAGIC);
        let file = open_file(path)?;
        let bytes = if packed {
            let unpacked = zstd::Decoder::new(file).map_err(Error::file(path))?;
            Bytes::Packed(Box::new(BufReader::with_capacity(BUFFER_BYTES, unpacked)))
        } else {
            let size = file.metadata().map_err(Error::file(path))?.len();
            Bytes::Plain { file: BufReader::with_capacity(BUFFER_BYTES, file), size }
        };
        let mut log = Self { bytes, path: path.into(), offset: 0, fault: None };
        if log.take_bytes(magic.len() as u64)? != magic {
            return Err(Error::Format { path: path.into(), reason: format!("is not {name}") });
        }
        Ok(log)
    }

    /// Bytes of the file; `None` where they are known only once they are unpacked.
    pub(crate) fn size(&self) -> Option<u64> {
        match self.bytes {
            Bytes::Plain { size, .. } => Some(size),
            Bytes::Packed(_) => None,
        }
    }

    /// Bytes gone through so far.
    pub(crate) fn offset(&self) -> u64 {
        self.offset
    }

    /// Bytes still to come; of a packed file at most so many.
    pub(crate) fn left(&self) -> u64 {
        self.size().unwrap_or(u64::MAX).saturating_sub(self.offset)
    }

    /// Goes on at byte `to`, which in a packed file lies further on; stops at its end.
    pub(crate) fn seek(&mut self, to: u64) -> Result<()> {
        if let Bytes::Plain { file, .. } = &mut self.bytes {
            #[expect(clippy::cast_possible_wrap, reason = "the difference wraps back to the signed step")]
            let step = to.wrapping_sub(self.offset) as i64;
            file.seek_relative(step).map_err(Error::file(&self.path))?;
            self.offset = to;
            return Ok(());
        }
        let step = to.saturating_sub(self.offset);
        let passed = io::copy(&mut (&mut *self).take(step), &mut io::sink());
        passed.map(|_| ()).map_err(Error::file(&self.path))
    }

    /// The next bytes, fewer than `length` where the file ends.
    pub(crate) fn take_bytes(&mut self, length: u64) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let read = (&mut *self).take(length).read_to_end(&mut bytes);
        read.map(|_| bytes).map_err(Error::file(&self.path))
    }

    /// What to tell of a packed file that cannot be unpacked further, once.
    pub(crate) fn take_fault(&mut self) -> Option<String> {
        let reason = self.fault.take()?;
        let at = self.offset;
        Some(format!(
            "the packed file is cut off or damaged after {at} bytes unpacked ({reason}); what comes before was read"
        ))
    }

    /// What to tell of a file that cannot be read on from byte `at`.
    pub(crate) fn end_note(&self, at: u64, what: &str) -> String {
        let end = self.size().unwrap_or(self.offset);
        format!(
            "the file is cut off or damaged: it ends at byte {end} and has {what} at byte {at}; what comes before was read"
        )
    }
}

/// What is packed ends where it cannot be unpacked further.
impl Read for LogFile {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = match &mut self.bytes {
            Bytes::Plain { file, .. } => file.read(bytes)?,
            Bytes::Packed(file) => file.read(bytes).unwrap_or_else(|error| {
                self.fault.get_or_insert(error.to_string());
                0
            }),
        };
        self.offset += read as u64;
        Ok(read)
    }
}
