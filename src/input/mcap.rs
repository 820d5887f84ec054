//! The records of an MCAP file, one after the other, whatever state the file is in.
//!
//! Records are framed here and chunks unpacked by the mcap crate one at a time: a damaged chunk costs
//! its own messages only, and a cut-off one gives those before the cut.

use std::path::Path;

use ::mcap::McapError;
use ::mcap::records::{Record as McapRecord, op};
use ::mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::base::Result;
use crate::input::log::{LogFile, Record, Records};

/// Opcode and length before each record.
const RECORD_HEADER: u64 = 9;

/// Largest chunk, packed or not, and largest record that is read, bytes.
const MAX_RECORD_BYTES: usize = 512 << 20;

/// Opcode, length, summary start, summary offset start, checksum, then the magic.
const FOOTER_AND_MAGIC: u64 = 9 + 20 + 8;

/// A chunk while it is unpacked; its bytes are fed to the reader as that asks for them.
struct Chunk {
    reader: Box<LinearReader>,
    body: Vec<u8>,
    fed: usize,
    offset: u64,
    cut: bool,
}

impl Chunk {
    fn new(offset: u64, length: u64, body: Vec<u8>, cut: bool) -> Self {
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_record_length_limit(MAX_RECORD_BYTES)
            .with_prevalidate_chunk_crcs(!cut);
        let mut reader = Box::new(LinearReader::new_with_options(options));
        let header = reader.insert(9);
        header[0] = op::CHUNK;
        header[1..9].copy_from_slice(&length.to_le_bytes());
        reader.notify_read(9);
        Self { reader, body, fed: 0, offset, cut }
    }

    /// The next record, if it is of use; `None` at the end of the chunk.
    fn next(&mut self, wanted: &dyn Fn(u32) -> bool) -> Option<Result<Option<Record>, McapError>> {
        loop {
            let wish = match self.reader.next_event()? {
                Ok(LinearReadEvent::ReadRequest(wish)) => wish,
                Ok(LinearReadEvent::Record { opcode, data }) => return Some(parse(opcode, data, wanted)),
                Err(error) => return Some(Err(error)),
            };
            let rest = &self.body[self.fed..];
            let given = &rest[..rest.len().min(wish)];
            self.reader.insert(given.len()).copy_from_slice(given);
            self.reader.notify_read(given.len());
            self.fed += given.len();
        }
    }
}

/// Whether a chunk record's header, with a compression name of the stated length, and its packed
/// records fill the record exactly. What does not could make a reader run over the end.
fn sizes_agree(body: &[u8]) -> bool {
    let number = |at: usize| {
        body.get(at..).and_then(|rest| rest.first_chunk::<4>()).map(|&four| u32::from_le_bytes(four))
    };
    let Some(name_bytes) = number(28).map(|bytes| bytes as usize) else { return false };
    let header_bytes = 40_usize.saturating_add(name_bytes);
    let packed = body.get(header_bytes.saturating_sub(8)..).and_then(|rest| rest.first_chunk::<8>());
    packed.is_some_and(|&packed| u64::from_le_bytes(packed) == (body.len() - header_bytes) as u64)
}

/// A record, where it is of use.
fn parse(opcode: u8, data: &[u8], wanted: &dyn Fn(u32) -> bool) -> Result<Option<Record>, McapError> {
    let unwanted = || data.first_chunk::<2>().is_none_or(|&id| !wanted(u16::from_le_bytes(id).into()));
    match opcode {
        op::MESSAGE if unwanted() => return Ok(None),
        op::SCHEMA | op::CHANNEL | op::MESSAGE | op::STATISTICS => {}
        _ => return Ok(None),
    }
    Ok(match ::mcap::parse_record(opcode, data)? {
        McapRecord::Schema { header, .. } => Some(Record::Schema { id: header.id, name: header.name }),
        McapRecord::Channel(channel) => Some(Record::Channel {
            id: channel.id.into(),
            schema_id: channel.schema_id,
            topic: channel.topic,
            message_encoding: channel.message_encoding,
        }),
        McapRecord::Message { header, data } => Some(Record::Message {
            channel_id: header.channel_id.into(),
            log_time_ns: header.log_time,
            data: data.into_owned(),
        }),
        McapRecord::Statistics(statistics) => Some(Record::Statistics {
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
        std::mem::take(&mut self.notes)
    }

    fn summary(path: &Path) -> Result<Vec<Record>> {
        let mut records = Self::open(path)?;
        let Some(footer_at) = records.file.size().checked_sub(FOOTER_AND_MAGIC).filter(|&at| at >= 8) else {
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
                Some(Ok(Some(record))) => return Some(record),
                Some(Ok(None)) => {}
                Some(Err(error)) => {
                    if !chunk.cut {
                        let at = chunk.offset;
                        self.notes
                            .push(format!("the chunk at byte {at} is damaged ({error}): messages are lost"));
                    }
                    self.chunk = None;
                }
                None => self.chunk = None,
            }
        }
    }

    fn next_in_file(&mut self, wanted: &dyn Fn(u32) -> bool) -> Result<Option<Record>> {
        let at = self.file.offset();
        if self.file.left() < RECORD_HEADER {
            self.end_at_cut(at);
            return Ok(None);
        }
        let header = self.file.take_bytes(RECORD_HEADER)?;
        let (&opcode, length) = match header.split_first() {
            Some((opcode, length)) => {
                (opcode, length.first_chunk().map_or(0, |&length| u64::from_le_bytes(length)))
            }
            None => return Ok(None),
        };
        let there = length.min(self.file.left());
        match opcode {
            op::DATA_END | op::FOOTER => self.ended = true,
            0 => self.end_at(at, "a record of no kind"),
            op::CHUNK => self.open_chunk(at, length, there)?,
            _ if there < length => self.end_at_cut(at),
            op::SCHEMA | op::CHANNEL | op::MESSAGE | op::STATISTICS if length <= MAX_RECORD_BYTES as u64 => {
                let body = self.file.take_bytes(length)?;
                return Ok(parse(opcode, &body, wanted).unwrap_or_else(|error| {
                    self.notes
                        .push(format!("the record at byte {at} is damaged ({error}) and was passed over"));
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
    fn open_chunk(&mut self, at: u64, length: u64, there: u64) -> Result<()> {
        let cut = there < length;
        if there > MAX_RECORD_BYTES as u64 {
            self.notes.push(format!("the chunk at byte {at} is larger than 512 MiB and was passed over"));
            self.file.seek(self.file.offset() + there)?;
        } else {
            let body = self.file.take_bytes(there)?;
            if cut || sizes_agree(&body) {
                self.chunk = Some(Chunk::new(at, length, body, cut));
            } else {
                self.notes
                    .push(format!("the chunk at byte {at} contradicts its own length and was passed over"));
            }
        }
        if cut {
            self.end_at_cut(at);
        }
        Ok(())
    }

    fn end_at_cut(&mut self, at: u64) {
        self.end_at(at, "a record that is not complete");
    }

    fn end_at(&mut self, at: u64, what: &str) {
        self.ended = true;
        self.notes.push(self.file.end_note(at, what));
    }
}
