//! An MCAP file of ROS 2 messages: profile `ros2`, zstd chunks, CDR with `ros2msg` schemas.

use std::collections::{BTreeMap, HashMap};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use ::mcap::records::MessageHeader;
use ::mcap::{Compression, McapError, WriteOptions, Writer};

use crate::base::{Error, Result};
use crate::message::RosMessage;
use crate::message::ros2::encode_cdr;
use crate::message::schema;
use crate::output::{End, StagedFile, encode_error};

/// A crash loses at most this many results.
const RESULTS_PER_FLUSH: u64 = 15;

/// Channel of a topic, and how many messages it has.
struct Channel {
    id: u16,
    sequence: u32,
}

/// A file that messages are appended to. Dropping it completes the file; `finish` says whether that worked.
pub struct RosFile<W: Write + Seek> {
    path: PathBuf,
    writer: Option<Writer<W>>,
    channels: HashMap<String, Channel>,
    results: u64,
}

impl<W: Write + Seek> RosFile<W> {
    /// Starts a file in `target`; `path` names it in errors. What cannot seek, as a pipe, is written in one go: then a chunk is
    /// held in memory until it is complete.
    ///
    /// # Errors
    /// [`Error::File`] where the header cannot be written.
    pub fn new(mut target: W, path: &Path) -> Result<Self> {
        let here = target.stream_position().map_err(Error::file(path))?;
        let seeks = target.seek(SeekFrom::Start(here)).is_ok();
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("limpid ", env!("CARGO_PKG_VERSION")))
            .compression(Some(Compression::Zstd))
            .compression_threads(0)
            .disable_seeking(!seeks);
        let writer = options.create(target).map_err(|e| mcap_error(path, e))?;
        Ok(Self { path: path.into(), writer: Some(writer), channels: HashMap::new(), results: 0 })
    }

    /// Appends `message` on `topic` with `stamp_ns` as log and publish time.
    ///
    /// # Errors
    /// [`Error::File`] where the target does not take it, [`Error::Encode`] after `finish`.
    pub fn write<M: RosMessage>(&mut self, topic: &str, stamp_ns: u64, message: &M) -> Result<()> {
        if !self.channels.contains_key(topic) {
            self.add_channel(topic, M::TYPE)?;
        }
        let data = encode_cdr(M::TYPE, message).map_err(|e| encode_error(&self.path, e))?;
        self.append(topic, stamp_ns, &data)
    }

    /// Appends a message on a topic that has a channel.
    fn append(&mut self, topic: &str, stamp_ns: u64, data: &[u8]) -> Result<()> {
        let writer = self.writer.as_mut().ok_or_else(|| finished(&self.path))?;
        if let Some(channel) = self.channels.get_mut(topic) {
            let header = MessageHeader {
                channel_id: channel.id,
                sequence: channel.sequence,
                log_time: stamp_ns,
                publish_time: stamp_ns,
            };
            writer.write_to_known_channel(&header, data).map_err(|e| mcap_error(&self.path, e))?;
            channel.sequence = channel.sequence.wrapping_add(1);
        }
        Ok(())
    }

    /// Whether no message was written.
    pub fn is_empty(&self) -> bool {
        self.channels.is_empty()
    }

    /// Ends what belongs to one result or frame; every fifteenth time what was written is flushed.
    ///
    /// # Errors
    /// As [`Self::flush`].
    pub fn end_result(&mut self) -> Result<()> {
        self.results += 1;
        if self.results.is_multiple_of(RESULTS_PER_FLUSH) { self.flush() } else { Ok(()) }
    }

    /// Closes the chunk in work, so that all messages so far are readable even if the file is never completed.
    ///
    /// # Errors
    /// [`Error::File`] where the target does not take it, [`Error::Encode`] after `finish`.
    pub fn flush(&mut self) -> Result<()> {
        let writer = self.writer.as_mut().ok_or_else(|| finished(&self.path))?;
        writer.flush().map_err(|e| mcap_error(&self.path, e))
    }

    /// Writes index and footer, and gives the target back; `None` if that was done before.
    ///
    /// # Errors
    /// [`Error::File`] where the target does not take it.
    pub fn finish(&mut self) -> Result<Option<W>> {
        let Some(mut writer) = self.writer.take() else { return Ok(None) };
        writer.finish().map_err(|e| mcap_error(&self.path, e))?;
        let mut target = writer.into_inner();
        target.flush().map_err(Error::file(&self.path))?;
        Ok(Some(target))
    }

    fn add_channel(&mut self, topic: &str, type_name: &str) -> Result<()> {
        let text = schema::full_text(type_name).map_err(|e| encode_error(&self.path, e))?;
        let writer = self.writer.as_mut().ok_or_else(|| finished(&self.path))?;
        let channel = writer
            .add_schema(type_name, "ros2msg", text.as_bytes())
            .and_then(|schema| writer.add_channel(schema, topic, "cdr", &BTreeMap::new()));
        let id = channel.map_err(|e| mcap_error(&self.path, e))?;
        self.channels.insert(topic.to_owned(), Channel { id, sequence: 0 });
        Ok(())
    }
}

/// Ends a file that is not complete; where it is, unless it is empty.
pub(crate) fn abandon(file: &mut RosFile<StagedFile>, end: End) -> Result<Option<PathBuf>> {
    let is_empty = file.is_empty();
    let Some(staged) = file.finish()? else { return Ok(None) };
    if is_empty {
        staged.discard();
        return Ok(None);
    }
    Ok(Some(staged.keep(end == End::Stopped)))
}

fn finished(path: &Path) -> Error {
    encode_error(path, "written to after it was finished")
}

fn mcap_error(path: &Path, error: McapError) -> Error {
    match error {
        McapError::Io(source) => Error::File { path: path.into(), source },
        other => encode_error(path, other),
    }
}
