//! The records of a ROS 1 bag (format 2.0), one after the other, whatever state the file is in.
//!
//! Chunks are unpacked as they are read, so that what is in memory is a packed chunk and a message: a
//! damaged chunk costs its own messages only, and a cut-off one gives those before the cut.

use std::collections::BTreeMap;
use std::io::{self, BufReader, Cursor, Read};
use std::path::Path;

use bzip2::read::BzDecoder;

use crate::base::Result;
use crate::input::log::{LogFile, MAX_MESSAGE_BYTES, Record, Records, too_large};

/// First bytes of a bag of the version that is read.
pub(crate) const MAGIC: &[u8] = b"#ROSBAG V2.0\n";

/// Largest chunk that is read, packed or not, bytes.
const MAX_CHUNK_BYTES: u64 = 512 << 20;

/// Longest header of a record, bytes; message definitions are not part of it.
const MAX_HEADER_BYTES: u64 = 1 << 20;

mod op {
    pub(super) const MESSAGE: u8 = 2;
    pub(super) const BAG: u8 = 3;
    pub(super) const INDEX: u8 = 4;
    pub(super) const CHUNK: u8 = 5;
    pub(super) const CHUNK_INFO: u8 = 6;
    pub(super) const CONNECTION: u8 = 7;
}

/// Why a record cannot be read.
enum Fault {
    Cut,
    Damaged(String),
}

/// In memory, and what is unpacked from there: whatever is wrong is wrong with the data.
impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Self::Damaged(error.to_string())
    }
}

fn damaged<T>(reason: &str) -> Result<T, Fault> {
    Err(Fault::Damaged(reason.into()))
}

/// Fields of the form `name=value`, each after its length.
struct Fields(Vec<u8>);

impl Fields {
    fn get(&self, name: &str) -> Option<&[u8]> {
        let mut rest = &self.0[..];
        while let Some((length, after)) = rest.split_first_chunk() {
            let (field, after) = after.split_at_checked(u32::from_le_bytes(*length) as usize)?;
            let value = field.strip_prefix(name.as_bytes()).and_then(|field| field.strip_prefix(b"="));
            if value.is_some() {
                return value;
            }
            rest = after;
        }
        None
    }

    fn number(&self, name: &str) -> Option<u32> {
        self.get(name)?.try_into().ok().map(u32::from_le_bytes)
    }

    fn text(&self, name: &str) -> Option<String> {
        self.get(name).map(|value| String::from_utf8_lossy(value).into_owned())
    }

    /// Nanoseconds since the Unix epoch.
    fn time_ns(&self, name: &str) -> Option<u64> {
        let &[s0, s1, s2, s3, n0, n1, n2, n3] = self.get(name)? else { return None };
        let (sec, nsec) = (u32::from_le_bytes([s0, s1, s2, s3]), u32::from_le_bytes([n0, n1, n2, n3]));
        Some(u64::from(sec) * 1_000_000_000 + u64::from(nsec))
    }
}

/// A record up to its data.
struct Head {
    op: u8,
    fields: Fields,
    data_bytes: u64,
}

impl Head {
    /// `None` where nothing follows.
    fn read(from: &mut dyn Read) -> Result<Option<Self>, Fault> {
        let mut length = Vec::new();
        from.take(4).read_to_end(&mut length)?;
        if length.is_empty() {
            return Ok(None);
        }
        let header_bytes = u64::from(number(&length)?);
        if header_bytes > MAX_HEADER_BYTES {
            return damaged("a record's header is longer than any");
        }
        let fields = Fields(read_exactly(from, header_bytes)?);
        let data_bytes = u64::from(number(&read_exactly(from, 4)?)?);
        match fields.get("op") {
            Some(&[op]) => Ok(Some(Self { op, fields, data_bytes })),
            _ => damaged("a record does not say what it is"),
        }
    }

    fn is_too_large(&self) -> bool {
        self.data_bytes > MAX_MESSAGE_BYTES
    }

    /// What to tell of a message that is wanted and passed over; `place`: where it lies.
    fn note(&self, place: &str, wanted: &dyn Fn(u32) -> bool) -> Option<String> {
        let is_wanted = self.op == op::MESSAGE && self.fields.number("conn").is_some_and(wanted);
        (is_wanted && self.is_too_large()).then(|| too_large(self.data_bytes, place))
    }

    /// The record, where it is of use; its data is gone through in any case.
    fn record(self, from: &mut dyn Read, wanted: &dyn Fn(u32) -> bool) -> Result<Option<Record>, Fault> {
        let connection = self.fields.number("conn");
        match (self.op, connection) {
            (op::MESSAGE, Some(channel_id)) if wanted(channel_id) && !self.is_too_large() => {
                let data = read_exactly(from, self.data_bytes)?;
                Ok(Some(Record::Message {
                    channel_id,
                    log_time_ns: self.fields.time_ns("time").unwrap_or(0),
                    data,
                }))
            }
            (op::CONNECTION, Some(id)) if !self.is_too_large() => {
                let about = Fields(read_exactly(from, self.data_bytes)?);
                let named = self.fields.text("topic").zip(about.text("type"));
                let message_encoding = "ros1".into();
                Ok(named.map(|(topic, type_name)| Record::Topic { id, topic, type_name, message_encoding }))
            }
            _ => {
                let skipped = io::copy(&mut from.take(self.data_bytes), &mut io::sink())?;
                if skipped == self.data_bytes { Ok(None) } else { Err(Fault::Cut) }
            }
        }
    }
}

fn number(bytes: &[u8]) -> Result<u32, Fault> {
    bytes.try_into().map(u32::from_le_bytes).map_err(|_| Fault::Cut)
}

fn read_exactly(from: &mut dyn Read, length: u64) -> Result<Vec<u8>, Fault> {
    let mut bytes = Vec::new();
    from.take(length).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == length { Ok(bytes) } else { Err(Fault::Cut) }
}

/// A chunk while it is unpacked.
struct Chunk {
    records: Box<dyn Read + Send>,
    offset: u64,
    cut: bool,
}

/// The records in a chunk's bytes, at most as many bytes of them as its header says.
fn unpack(compression: Option<&[u8]>, size: u64, packed: Vec<u8>) -> Result<Box<dyn Read + Send>, Fault> {
    let packed = Cursor::new(packed);
    Ok(match compression {
        Some(b"none") => Box::new(packed),
        Some(b"lz4") => Box::new(BufReader::new(lz4::Decoder::new(packed)?).take(size)),
        Some(b"bz2") => Box::new(BufReader::new(BzDecoder::new(packed)).take(size)),
        _ => return damaged("its compression is none of none, lz4 and bz2"),
    })
}

/// What a bag says of itself at its beginning.
struct BagHeader {
    index_at: u64,
    connections: u32,
    chunks: u32,
}

/// See the module.
pub(crate) struct BagRecords {
    file: LogFile,
    /// Where the recorder wrote its index when it closed the bag; 0 where it did not.
    index_at: u64,
    chunk: Option<Chunk>,
    ended: bool,
    notes: Vec<String>,
}

impl Records for BagRecords {
    fn open(path: &Path) -> Result<Self> {
        let file = LogFile::open(path, MAGIC, "a ROS 1 bag of format 2.0")?;
        Ok(Self { file, index_at: 0, chunk: None, ended: false, notes: Vec::new() })
    }

    fn summary(path: &Path) -> Result<Vec<Record>> {
        let mut records = Self::open(path)?;
        Ok(records.index()?.unwrap_or_default())
    }

    fn next_in_chunk(&mut self, wanted: &dyn Fn(u32) -> bool) -> Option<Record> {
        loop {
            let chunk = self.chunk.as_mut()?;
            let head = Head::read(&mut chunk.records);
            let next = head.and_then(|head| match head {
                Some(head) => {
                    let place = format!("in the chunk at byte {}", chunk.offset);
                    self.notes.extend(head.note(&place, wanted));
                    head.record(&mut chunk.records, wanted).map(Some)
                }
                None => Ok(None),
            });
            match next {
                Ok(Some(Some(record))) => return Some(record),
                Ok(Some(None)) => {}
                Ok(None) => self.chunk = None,
                Err(fault) => {
                    let (at, cut) = (chunk.offset, chunk.cut);
                    self.chunk = None;
                    if !cut {
                        self.note_chunk(at, fault);
                    }
                }
            }
        }
    }

    fn next_in_file(&mut self, wanted: &dyn Fn(u32) -> bool) -> Result<Option<Record>> {
        let at = self.file.offset();
        let head = match Head::read(&mut self.file) {
            Ok(Some(head)) => head,
            Ok(None) => {
                self.end_of_file(at);
                return Ok(None);
            }
            Err(fault) => {
                self.end_at(at, fault);
                return Ok(None);
            }
        };
        let cut = head.data_bytes > self.file.left();
        match head.op {
            op::CHUNK => self.open_chunk(at, &head)?,
            _ if cut => self.end_at(at, Fault::Cut),
            op::MESSAGE | op::CONNECTION => {
                self.notes.extend(head.note(&format!("at byte {at}"), wanted));
                match head.record(&mut self.file, wanted) {
                    Ok(record) => return Ok(record),
                    Err(fault) => self.end_at(at, fault),
                }
            }
            op::BAG | op::INDEX | op::CHUNK_INFO => {
                self.index_at = bag_header(&head).map_or(self.index_at, |bag| bag.index_at);
                self.file.seek(self.file.offset() + head.data_bytes)?;
            }
            _ => self.end_at(at, Fault::Damaged("a record of no kind".into())),
        }
        Ok(None)
    }

    fn ended(&self) -> bool {
        self.ended
    }

    fn offset(&self) -> u64 {
        self.file.offset()
    }

    fn take_notes(&mut self) -> Vec<String> {
        self.notes.extend(self.file.take_fault());
        std::mem::take(&mut self.notes)
    }
}

impl BagRecords {
    /// Connections and counts of a whole index, `None` where it is not whole.
    fn index(&mut self) -> Result<Option<Vec<Record>>> {
        let Ok(Some(head)) = Head::read(&mut self.file) else { return Ok(None) };
        let Some(bag) = bag_header(&head) else { return Ok(None) };
        let within = self.file.offset()..=self.file.size().unwrap_or(0);
        if !within.contains(&bag.index_at) {
            return Ok(None);
        }
        self.file.seek(bag.index_at)?;
        let (mut found, mut chunks, mut counts) = (Vec::new(), 0, BTreeMap::new());
        let mut span_ns: Option<[u64; 2]> = None;
        while let Ok(Some(head)) = Head::read(&mut self.file) {
            if head.data_bytes > self.file.left() {
                return Ok(None);
            }
            if head.op == op::CHUNK_INFO {
                chunks += 1;
                if let (Some(start_ns), Some(end_ns)) =
                    (head.fields.time_ns("start_time"), head.fields.time_ns("end_time"))
                {
                    let [first_ns, last_ns] = span_ns.unwrap_or([start_ns, end_ns]);
                    span_ns = Some([first_ns.min(start_ns), last_ns.max(end_ns)]);
                }
                count(&self.file.take_bytes(head.data_bytes)?, &mut counts);
            } else if let Ok(Some(record)) = head.record(&mut self.file, &|_| false) {
                found.push(record);
            }
        }
        let whole = chunks == bag.chunks && found.len() == bag.connections as usize;
        found.push(Record::Statistics { message_counts: counts.into_iter().collect(), span_ns });
        Ok(whole.then_some(found))
    }

    /// Reads what is there of a chunk and starts to unpack it.
    fn open_chunk(&mut self, at: u64, head: &Head) -> Result<()> {
        let there = head.data_bytes.min(self.file.left());
        let size = u64::from(head.fields.number("size").unwrap_or(0));
        let (opened, cut) = if there.max(size) > MAX_CHUNK_BYTES {
            let from = self.file.offset();
            self.file.seek(from + there)?;
            (damaged("it is larger than 512 MiB"), self.file.offset() - from < head.data_bytes)
        } else {
            let packed = self.file.take_bytes(there)?;
            let cut = (packed.len() as u64) < head.data_bytes;
            (unpack(head.fields.get("compression"), size, packed), cut)
        };
        match opened {
            Ok(records) => self.chunk = Some(Chunk { records, offset: at, cut }),
            Err(fault) => self.note_chunk(at, fault),
        }
        if cut {
            self.end_at(at, Fault::Cut);
        }
        Ok(())
    }

    fn note_chunk(&mut self, at: u64, fault: Fault) {
        let reason = match fault {
            Fault::Cut => "it ends within a record".into(),
            Fault::Damaged(reason) => reason,
        };
        self.notes.push(format!("the chunk at byte {at} is damaged ({reason}): messages are lost"));
    }

    fn end_of_file(&mut self, at: u64) {
        self.ended = true;
        if self.index_at == 0 {
            self.notes.push("the bag was not closed by its recorder; what it holds was read".into());
        } else if self.index_at > at {
            self.notes.push(self.file.end_note(at, "no index"));
        }
    }

    fn end_at(&mut self, at: u64, fault: Fault) {
        self.ended = true;
        let what = match fault {
            Fault::Cut => "a record that is not complete".into(),
            Fault::Damaged(reason) => reason,
        };
        self.notes.push(self.file.end_note(at, &what));
    }
}

fn bag_header(head: &Head) -> Option<BagHeader> {
    let index_at = head.fields.get("index_pos")?.try_into().ok().map(u64::from_le_bytes)?;
    let connections = head.fields.number("conn_count")?;
    let chunks = head.fields.number("chunk_count")?;
    (head.op == op::BAG).then_some(BagHeader { index_at, connections, chunks })
}

/// Adds the counts of a chunk's messages, pairs of connection and count.
fn count(pairs: &[u8], counts: &mut BTreeMap<u32, u64>) {
    for &[c0, c1, c2, c3, n0, n1, n2, n3] in pairs.as_chunks().0 {
        let messages = u64::from(u32::from_le_bytes([n0, n1, n2, n3]));
        *counts.entry(u32::from_le_bytes([c0, c1, c2, c3])).or_default() += messages;
    }
}
