//! What the formats of logs have in common: records of channels and messages, one after the other.

use std::path::Path;

use crate::base::Result;

/// Largest message that is read, bytes: an image of 8192x5461 pixels of three bytes.
pub(crate) const MAX_MESSAGE_BYTES: u64 = 128 << 20;

/// What to tell of a message that is larger; `place`: where it lies.
pub(crate) fn too_large(bytes: u64, place: &str) -> String {
    let most = MAX_MESSAGE_BYTES >> 20;
    format!("a message of {} MiB {place} is passed over: at most {most} MiB are read", bytes >> 20)
}

/// What of a log is of use to a reader.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Record {
    /// MCAP: a message type, which channels name by its id.
    Schema {
        id: u16,
        name: String,
    },
    /// MCAP: a topic.
    Channel {
        id: u32,
        schema_id: u16,
        topic: String,
        message_encoding: String,
    },
    /// Other formats: a topic with its message type and how its messages are written, as MCAP names that.
    Topic {
        id: u32,
        topic: String,
        type_name: String,
        message_encoding: String,
    },
    Message {
        channel_id: u32,
        log_time_ns: u64,
        data: Vec<u8>,
    },
    /// How many messages the channels have; none where a channel is not named.
    Statistics {
        message_counts: Vec<(u32, u64)>,
        /// Log times of the first and the last message, nanoseconds.
        span_ns: Option<[u64; 2]>,
    },
}

/// The records of a log in order of the file, whatever state it is in.
pub(crate) trait Records {
    /// # Errors
    /// [`crate::Error::File`], and [`crate::Error::Format`] where the file does not start as it should.
    fn open(path: &Path) -> Result<Self>
    where
        Self: Sized;

    /// What the file says at its end about channels and counts; empty where there is nothing, as in a
    /// cut-off file.
    ///
    /// # Errors
    /// [`crate::Error::File`] and [`crate::Error::Format`] as [`Self::open`].
    fn summary(path: &Path) -> Result<Vec<Record>>
    where
        Self: Sized;

    /// The next record of the chunk that is open; `None` at its end.
    fn next_in_chunk(&mut self, wanted: &dyn Fn(u32) -> bool) -> Option<Record>;

    /// Goes on by a record of the file, which is given where it is of use and opened where it is a chunk.
    ///
    /// # Errors
    /// [`crate::Error::File`].
    fn next_in_file(&mut self, wanted: &dyn Fn(u32) -> bool) -> Result<Option<Record>>;

    /// Whether nothing more comes in the file.
    fn ended(&self) -> bool;

    /// Bytes of the file gone through so far.
    fn offset(&self) -> u64;

    /// What was met and should be told, each once.
    fn take_notes(&mut self) -> Vec<String>;

    /// The next record of use, messages only of channels that are `wanted`; `None` at the end of the
    /// data, or where the file is cut off or cannot be read on, which then is noted.
    ///
    /// # Errors
    /// [`crate::Error::File`] where the operating system fails to read.
    fn next(&mut self, wanted: &dyn Fn(u32) -> bool) -> Result<Option<Record>> {
        loop {
            if let Some(record) = self.next_in_chunk(wanted) {
                return Ok(Some(record));
            }
            if self.ended() {
                return Ok(None);
            }
            if let Some(record) = self.next_in_file(wanted)? {
                return Ok(Some(record));
            }
        }
    }
}
