//! A chunk of an MCAP file while it is unpacked: in memory are its packed bytes and one message.
//!
//! What a chunk says of its sizes is never a reason to take memory: bytes are taken as they come, and up to a bound.

use std::io::{self, BufReader, Cursor, Read};

use ::mcap::records::op;

use crate::input::log::{MAX_MESSAGE_BYTES, Record, too_large};

use super::parse;

/// Largest chunk that is read, packed or not, bytes.
pub(super) const MAX_CHUNK_BYTES: u64 = 512 << 20;

/// Chunks up to this size are unpacked once and held, bytes. Larger ones are unpacked twice, to be checked and to be read.
const HELD_BYTES: u64 = 16 << 20;

/// First and last time, size, checksum, length of the compression's name.
const FIXED_HEADER: usize = 8 + 8 + 8 + 4 + 4;

/// Opcode and length before each record.
const RECORD_HEADER: usize = 9;

/// Bytes unpacked at a time.
const PIECE_BYTES: usize = 1 << 16;

const CUT_RECORD: &str = "it ends within a record";

/// Channel, sequence number, log time and publish time of a message.
pub(super) const MESSAGE_HEADER: usize = 2 + 4 + 8 + 8;

/// Channel and log time of a message, nanoseconds.
pub(super) fn message_header(header: [u8; MESSAGE_HEADER]) -> (u32, u64) {
    let [c0, c1, _, _, _, _, t0, t1, t2, t3, t4, t5, t6, t7, ..] = header;
    (u16::from_le_bytes([c0, c1]).into(), u64::from_le_bytes([t0, t1, t2, t3, t4, t5, t6, t7]))
}

type Unpacked<'a> = Box<dyn Read + Send + 'a>;

#[derive(Debug, Clone, Copy)]
enum Compression {
    None,
    Zstd,
    Lz4,
}

impl Compression {
    fn named(name: &[u8]) -> Result<Self, String> {
        match name {
            b"" => Ok(Self::None),
            b"zstd" => Ok(Self::Zstd),
            b"lz4" => Ok(Self::Lz4),
            other => {
                let name = String::from_utf8_lossy(&other[..other.len().min(20)]);
                Err(format!("its compression `{name}` is neither zstd nor lz4"))
            }
        }
    }
}

/// What a chunk says of itself.
#[derive(Debug, Clone, Copy)]
struct Header {
    /// Bytes of the records, unpacked.
    size: u64,
    /// Checksum of the records, unpacked; 0: none.
    crc: u32,
    compression: Compression,
    /// Where the packed records start in the body.
    packed_at: usize,
}

impl Header {
    fn read(body: &[u8], cut: bool) -> Result<Self, String> {
        const CUT: &str = "its header is cut short";
        let (fixed, rest) = body.split_first_chunk::<FIXED_HEADER>().ok_or(CUT)?;
        let [.., s0, s1, s2, s3, s4, s5, s6, s7, c0, c1, c2, c3, n0, n1, n2, n3] = *fixed;
        let stated = u64::from_le_bytes([s0, s1, s2, s3, s4, s5, s6, s7]);
        let name_bytes = u32::from_le_bytes([n0, n1, n2, n3]) as usize;
        let (name, rest) = rest.split_at_checked(name_bytes).ok_or(CUT)?;
        let (packed_bytes, packed) = rest.split_first_chunk::<8>().ok_or(CUT)?;
        let packed_bytes = u64::from_le_bytes(*packed_bytes);
        if !cut && packed_bytes != packed.len() as u64 {
            return Err("it contradicts its own length".into());
        }
        let compression = Compression::named(name)?;
        // Records that are not packed say by themselves how many bytes they are.
        let size = if matches!(compression, Compression::None) { packed_bytes } else { stated };
        if size > MAX_CHUNK_BYTES {
            return Err(format!("it says that it unpacks to {} MiB, more than 512", size >> 20));
        }
        let crc = u32::from_le_bytes([c0, c1, c2, c3]);
        Ok(Self { size, crc, compression, packed_at: body.len() - packed.len() })
    }

    /// The records in a chunk's body, at most as many bytes as the header says and one more, which tells a wrong size.
    fn unpack<'a>(&self, mut body: Cursor<impl AsRef<[u8]> + Send + 'a>) -> Result<Unpacked<'a>, String> {
        body.set_position(self.packed_at as u64);
        let failed = |error: io::Error| error.to_string();
        let records: Unpacked<'a> = match self.compression {
            Compression::None => Box::new(body),
            Compression::Zstd => Box::new(buffered(zstd::Decoder::with_buffer(body).map_err(failed)?)),
            Compression::Lz4 => Box::new(buffered(lz4::Decoder::new(body).map_err(failed)?)),
        };
        Ok(Box::new(records.take(self.size.saturating_add(1))))
    }
}

/// See the module.
pub(super) struct Chunk {
    records: Unpacked<'static>,
    /// Bytes of records still to come.
    left: u64,
    /// Where in the file it lies, bytes.
    pub(super) offset: u64,
    /// Whether the file ends within it.
    pub(super) cut: bool,
}

impl Chunk {
    /// Starts to unpack the body of a chunk record. A checksum is checked first: what is wrong somewhere is trusted nowhere.
    pub(super) fn open(offset: u64, body: Vec<u8>, cut: bool) -> Result<Self, String> {
        let header = Header::read(&body, cut)?;
        let (size, checked) = (header.size, header.crc != 0 && !cut);
        if !checked || size > HELD_BYTES {
            if checked {
                check(header.unpack(Cursor::new(&body))?, &header)?;
            }
            return Ok(Self { records: header.unpack(Cursor::new(body))?, left: size, offset, cut });
        }
        let held = hold(header.unpack(Cursor::new(&body))?, &header)?;
        Ok(Self { records: Box::new(Cursor::new(held)), left: size, offset, cut })
    }

    /// The next record of use, or what is to be noted of one that is passed over; `None` at the end of the chunk.
    pub(super) fn next(&mut self, wanted: &dyn Fn(u32) -> bool) -> Result<Option<Found>, String> {
        while self.left > 0 {
            let (opcode, length) = record_header(&mut self.records, &mut self.left)?;
            match opcode {
                op::MESSAGE => {
                    if let Some(found) = self.message(length, wanted)? {
                        return Ok(Some(found));
                    }
                }
                op::SCHEMA | op::CHANNEL if length <= MAX_MESSAGE_BYTES => {
                    let body = self.take(length)?;
                    if let Some(record) = parse(opcode, &body).map_err(|error| error.to_string())? {
                        return Ok(Some(Found::Record(record)));
                    }
                }
                _ => self.skip(length)?,
            }
        }
        match self.records.read(&mut [0]) {
            Ok(0) => Ok(None),
            Ok(_) => Err("it holds more than it says".into()),
            Err(error) => Err(error.to_string()),
        }
    }

    /// A message of `length` bytes, its header included; `None` where it is not wanted.
    fn message(&mut self, length: u64, wanted: &dyn Fn(u32) -> bool) -> Result<Option<Found>, String> {
        let data_bytes =
            length.checked_sub(MESSAGE_HEADER as u64).ok_or("a message is shorter than its header")?;
        let header = self.take(MESSAGE_HEADER as u64)?;
        let (channel_id, log_time_ns) = header.first_chunk().map_or((0, 0), |&header| message_header(header));
        if !wanted(channel_id) || data_bytes > MAX_MESSAGE_BYTES {
            self.skip(data_bytes)?;
            let place = || format!("in the chunk at byte {}", self.offset);
            return Ok(wanted(channel_id).then(|| Found::Note(too_large(data_bytes, &place()))));
        }
        let data = self.take(data_bytes)?;
        Ok(Some(Found::Record(Record::Message { channel_id, log_time_ns, data })))
    }

    fn take(&mut self, length: u64) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        let read = (&mut self.records).take(length).read_to_end(&mut bytes);
        read.map_err(|error| error.to_string())?;
        self.went_through(bytes.len() as u64, length).map(|()| bytes)
    }

    fn skip(&mut self, length: u64) -> Result<(), String> {
        let skipped = io::copy(&mut (&mut self.records).take(length), &mut io::sink());
        self.went_through(skipped.map_err(|error| error.to_string())?, length)
    }

    fn went_through(&mut self, bytes: u64, of: u64) -> Result<(), String> {
        self.left -= bytes;
        if bytes == of { Ok(()) } else { Err(CUT_RECORD.into()) }
    }
}

/// What a chunk gives.
pub(super) enum Found {
    Record(Record),
    /// What to tell of a record that was passed over.
    Note(String),
}

fn buffered(unpacked: impl Read) -> impl Read {
    BufReader::with_capacity(PIECE_BYTES, unpacked)
}

/// Opcode and length in a record's header, of which and what follows `left` bytes are still to come; these become fewer by
/// the header.
fn opcode_and_length(header: [u8; RECORD_HEADER], left: &mut u64) -> Result<(u8, u64), String> {
    let [opcode, length @ ..] = header;
    let length = u64::from_le_bytes(length);
    *left = left.checked_sub(RECORD_HEADER as u64).ok_or(CUT_RECORD)?;
    match opcode {
        0 => Err("a record of no kind (opcode 0)".into()),
        _ if length > *left => Err("a record is longer than the rest of the chunk".into()),
        _ => Ok((opcode, length)),
    }
}

fn record_header(records: &mut dyn Read, left: &mut u64) -> Result<(u8, u64), String> {
    let mut header = [0; RECORD_HEADER];
    records.read_exact(&mut header).map_err(|error| match error.kind() {
        io::ErrorKind::UnexpectedEof => CUT_RECORD.into(),
        _ => error.to_string(),
    })?;
    opcode_and_length(header, left)
}

/// The records of a chunk whose framing, size and checksum are as its header says. What is not framed as records is not
/// unpacked to its end.
fn hold(mut records: impl Read, header: &Header) -> Result<Vec<u8>, String> {
    let (mut held, mut crc) = (Vec::new(), crc32fast::Hasher::new());
    let (mut at, mut left) = (0, header.size);
    loop {
        let before = held.len();
        let read = (&mut records).take(PIECE_BYTES as u64).read_to_end(&mut held);
        if read.map_err(|error| error.to_string())? == 0 {
            break;
        }
        crc.update(&held[before..]);
        while let Some(&record) = held.get(at..).and_then(|rest| rest.first_chunk()) {
            let (_, length) = opcode_and_length(record, &mut left)?;
            left -= length;
            at = at
                .saturating_add(RECORD_HEADER)
                .saturating_add(usize::try_from(length).unwrap_or(usize::MAX));
        }
    }
    check_end(held.len() as u64, crc, header).map(|()| held)
}

/// As [`hold`], of a chunk that is too large to be held.
fn check(records: impl Read, header: &Header) -> Result<(), String> {
    let mut records = Summed { from: records, bytes: 0, crc: crc32fast::Hasher::new() };
    let mut left = header.size;
    while left > 0 {
        let (_, length) = record_header(&mut records, &mut left)?;
        io::copy(&mut (&mut records).take(length), &mut io::sink()).map_err(|error| error.to_string())?;
        left -= length;
    }
    io::copy(&mut records, &mut io::sink()).map_err(|error| error.to_string())?;
    check_end(records.bytes, records.crc, header)
}

fn check_end(bytes: u64, crc: crc32fast::Hasher, header: &Header) -> Result<(), String> {
    if bytes != header.size {
        let more = if bytes > header.size { "more" } else { "less" };
        return Err(format!("it holds {more} than the {} bytes that it says", header.size));
    }
    let (found, stated) = (crc.finalize(), header.crc);
    if found == stated {
        return Ok(());
    }
    Err(format!("its checksum is {found:08x} in place of {stated:08x}"))
}

/// Counts and sums what is read.
struct Summed<R> {
    from: R,
    bytes: u64,
    crc: crc32fast::Hasher,
}

impl<R: Read> Read for Summed<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.from.read(bytes)?;
        self.crc.update(&bytes[..read]);
        self.bytes += read as u64;
        Ok(read)
    }
}
