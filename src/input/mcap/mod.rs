//! The records of an MCAP file, one after the other, whatever state the file is in.
//!
//! A damaged chunk costs its own messages only, and a cut-off one gives those before the cut.

mod chunk;

use std::path::Path;

use ::mcap::McapError;
use ::mcap::records::{Record as McapRecord, op};

use crate::base::Result;
use crate::input::log::{LogFile, MAX_MESSAGE_BYTES, Record, Records, too_large};
use crate::input::mcap::chunk::{Chunk, Found, MAX_CHUNK_BYTES, MESSAGE_HEADER, message_header};

/// Opcode and length before each record.
const RECORD_HEADER: usize = 9;

/// Opcode, length, summary start, summary offset start, checksum, then the magic.
const FOOTER_AND_MAGIC: u64 = 9 + 20 + 8;

/// A record, where it is of use.
fn parse(opcode: u8, data: &[u8]) -> Result<Option<Record>, McapError> {
    Ok(match ::mcap::parse_record(opcode, data)? {
        McapRecord::Schema { header, .. } => Some(Record::Schema { id: header.id, name: header.name }),
        McapRecord::Channel(channel) => Some(Record::Channel {
            id: channel.id.into(),
            schema_id: channel.schema_id,
            topic: channel.topic,
            message_encoding: channel.message_encoding,
        }),
        McapRecord::Statistics(statistics) => Some(Record::Statistics {
            span_ns: (statistics.message_count > 0)
                .then_some([statistics.message_start_time, statistics.message_end_time]),
            message_counts: statistics
                .channel_message_counts
                .into_iter()
                .map(|(id, count)| (id.into(), count))
                .collect(),
        }),
        _ => None,
    })
}

/// See the module.
pub(crate) struct McapRecords {
    file: LogFile,
    chunk: Option<Chunk>,
    ended: bool,
    notes: Vec<String>,
}

impl Records for McapRecords {
    fn open(path: &Path) -> Result<Self> {
        let file = LogFile::open(path, ::mcap::MAGIC, "an MCAP file")?;
        Ok(Self { file, chunk: None, ended: false, notes: Vec::new() })
    }

    fn offset(&self) -> u64 {
        self.file.offset()
    }

    fn take_notes(&mut self) -> Vec<String> {
        self.notes.extend(self.file.take_fault());
        std::mem::take(&mut self.notes)
    }

    fn summary(path: &Path) -> Result<Vec<Record>> {
        let mut records = Self::open(path)?;
        let size = records.file.size().unwrap_or(0);
        let Some(footer_at) = size.checked_sub(FOOTER_AND_MAGIC).filter(|&at| at >= 8) else {
            return Ok(Vec::new());
        };
        records.file.seek(footer_at)?;
        let footer = records.file.take_bytes(FOOTER_AND_MAGIC)?;
        if footer.first() != Some(&op::FOOTER) || !footer.ends_with(::mcap::MAGIC) {
            return Ok(Vec::new());
        }
        let start =
            footer.get(9..).and_then(|body| body.first_chunk()).map_or(0, |&at| u64::from_le_bytes(at));
        if start == 0 || start >= footer_at {
            return Ok(Vec::new());
        }
        records.file.seek(start)?;
        let mut found = Vec::new();
        while let Some(record) = records.next(&|_| false)? {
            found.push(record);
        }
        Ok(found)
    }

    fn next_in_chunk(&mut self, wanted: &dyn Fn(u32) -> bool) -> Option<Record> {
        loop {
            let chunk = self.chunk.as_mut()?;
            match chunk.next(wanted) {
                Ok(Some(Found::Record(record))) => return Some(record),
                Ok(Some(Found::Note(note))) => self.notes.push(note),
                Ok(None) => self.chunk = None,
                Err(reason) => {
                    let (at, cut) = (chunk.offset, chunk.cut);
                    self.chunk = None;
                    if !cut {
                        self.note_chunk(at, &reason);
                    }
                }
            }
        }
    }

    fn next_in_file(&mut self, wanted: &dyn Fn(u32) -> bool) -> Result<Option<Record>> {
        let at = self.file.offset();
        let header = self.file.take_bytes(RECORD_HEADER as u64)?;
        let Some(&[opcode, ref length @ ..]) = header.first_chunk::<RECORD_HEADER>() else {
            self.end_at_cut(at);
            return Ok(None);
        };
        let length = u64::from_le_bytes(*length);
        match opcode {
            op::DATA_END | op::FOOTER => self.ended = true,
            0 => self.end_at(at, "a record of no kind"),
            op::CHUNK => self.open_chunk(at, length)?,
            _ if length > self.file.left() => self.end_at_cut(at),
            op::MESSAGE => return self.message(at, length, wanted),
            op::SCHEMA | op::CHANNEL | op::STATISTICS if length <= MAX_MESSAGE_BYTES => {
                let body = self.file.take_bytes(length)?;
                return Ok(parse(opcode, &body).unwrap_or_else(|error| {
                    self.note_record(at, &error.to_string());
                    None
                }));
            }
            _ => self.file.seek(self.file.offset() + length)?,
        }
        Ok(None)
    }

    fn ended(&self) -> bool {
        self.ended
    }
}

impl McapRecords {
    /// Reads what is there of a chunk and starts to unpack it.
    fn open_chunk(&mut self, at: u64, length: u64) -> Result<()> {
        let there = length.min(self.file.left());
        if there > MAX_CHUNK_BYTES {
            self.note_chunk(at, "it is larger than 512 MiB");
            self.file.seek(self.file.offset() + there)?;
        } else {
            let body = self.file.take_bytes(there)?;
            let cut = (body.len() as u64) < length;
            match Chunk::open(at, body, cut) {
                Ok(chunk) => self.chunk = Some(chunk),
                Err(reason) if !cut => self.note_chunk(at, &reason),
                Err(_) => {}
            }
        }
        if self.file.offset() < (at + RECORD_HEADER as u64).saturating_add(length) {
            self.end_at_cut(at);
        }
        Ok(())
    }

    /// A message that is in no chunk.
    fn message(&mut self, at: u64, length: u64, wanted: &dyn Fn(u32) -> bool) -> Result<Option<Record>> {
        let Some(data_bytes) = length.checked_sub(MESSAGE_HEADER as u64) else {
            self.note_record(at, "it is shorter than a message's header");
            self.file.seek(self.file.offset() + length)?;
            return Ok(None);
        };
        let header = self.file.take_bytes(MESSAGE_HEADER as u64)?;
        let (channel_id, log_time_ns) = header.first_chunk().map_or((0, 0), |&header| message_header(header));
        if !wanted(channel_id) || data_bytes > MAX_MESSAGE_BYTES {
            self.file.seek(self.file.offset() + data_bytes)?;
            self.notes.extend(wanted(channel_id).then(|| too_large(data_bytes, &format!("at byte {at}"))));
            return Ok(None);
        }
        let data = self.file.take_bytes(data_bytes)?;
        if (data.len() as u64) < data_bytes {
            self.end_at_cut(at);
            return Ok(None);
        }
        Ok(Some(Record::Message { channel_id, log_time_ns, data }))
    }

    fn note_chunk(&mut self, at: u64, reason: &str) {
        self.notes.push(format!("the chunk at byte {at} is damaged ({reason}): messages are lost"));
    }

    fn note_record(&mut self, at: u64, reason: &str) {
        self.notes.push(format!("the record at byte {at} is damaged ({reason}) and was passed over"));
    }

    fn end_at_cut(&mut self, at: u64) {
        self.end_at(at, "a record that is not complete");
    }

    fn end_at(&mut self, at: u64, what: &str) {
        self.ended = true;
        self.notes.push(self.file.end_note(at, what));
    }
}
