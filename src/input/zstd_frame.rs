//! What rosbag2 packs with zstd as a whole: a file, or each message.

use std::io::Read;
use std::path::Path;

use crate::base::{Error, Result};
use crate::input::log::MAX_MESSAGE_BYTES;
use crate::input::start::{START_BYTES, open_file};
use crate::message::decode_error;

/// First bytes of a frame.
pub(in crate::input) const MAGIC: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// Whether a message is a frame: no message that is read begins like one.
pub(in crate::input) fn is_packed(message: &[u8]) -> bool {
    message.starts_with(&MAGIC)
}

/// The message in a frame.
///
/// # Errors
/// [`Error::Decode`] for a damaged frame, and for a message of more than 128 MiB, whatever the frame says of it.
pub(in crate::input) fn unpack(packed: &[u8]) -> Result<Vec<u8>> {
    let failed = |error: std::io::Error| decode_error("zstd frame", error.to_string());
    let mut message = Vec::new();
    let decoder = zstd::Decoder::with_buffer(packed).map_err(failed)?;
    decoder.take(MAX_MESSAGE_BYTES + 1).read_to_end(&mut message).map_err(failed)?;
    if message.len() as u64 > MAX_MESSAGE_BYTES {
        let most = MAX_MESSAGE_BYTES >> 20;
        return Err(decode_error("zstd frame", format!("it unpacks to more than {most} MiB")));
    }
    Ok(message)
}

/// The first bytes of what is in a packed file, fewer where there are fewer.
///
/// # Errors
/// [`Error::File`]; [`Error::Format`] for a file that is not packed with zstd.
pub(in crate::input) fn start_of_unpacked(path: &Path) -> Result<Vec<u8>> {
    let decoder = zstd::Decoder::new(open_file(path)?).map_err(Error::file(path))?;
    let mut start = Vec::new();
    decoder.take(START_BYTES).read_to_end(&mut start).map_err(|error| Error::Format {
        path: path.into(),
        reason: format!("is packed with zstd and damaged at its beginning ({error})"),
    })?;
    Ok(start)
}
