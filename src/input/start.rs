//! The first bytes of a recording's file, by which its reader is chosen.

use std::fs::{File, FileType};
use std::io::Read;
use std::path::Path;

use crate::base::{Error, Result};

/// Bytes that tell the formats apart.
pub(in crate::input) const START_BYTES: u64 = 16;

/// The first 16 bytes of a file, fewer where it has fewer.
///
/// # Errors
/// [`Error::File`]; [`Error::Format`] for what is not a file: it is not opened, as opening a pipe may wait for ever.
pub(in crate::input) fn start_of(path: &Path) -> Result<Vec<u8>> {
    let file = open_file(path)?;
    let mut start = Vec::new();
    file.take(START_BYTES).read_to_end(&mut start).map_err(Error::file(path))?;
    Ok(start)
}

/// Opens a file that can be read more than once.
///
/// # Errors
/// As [`start_of`].
pub(in crate::input) fn open_file(path: &Path) -> Result<File> {
    if path.as_os_str() == "-" && !path.exists() {
        return Err(not_a_file(path, "standard input"));
    }
    let kind = std::fs::metadata(path).map_err(Error::file(path))?.file_type();
    if !kind.is_file() {
        return Err(not_a_file(path, name_of(kind)));
    }
    File::open(path).map_err(Error::file(path))
}

fn not_a_file(path: &Path, what: &str) -> Error {
    let reason = format!(
        "is {what}; a recording is read more than once, and from its end: save it as a file and give its name"
    );
    Error::Format { path: path.into(), reason }
}

/// What is not a file, in words.
fn name_of(kind: FileType) -> &'static str {
    if kind.is_dir() {
        return "a folder";
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_socket() {
            return "a socket";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
    }
    "not a file"
}
