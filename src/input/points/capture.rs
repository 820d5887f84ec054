//! Network packets of a capture file, pcap or pcapng, one after the other.

use std::fs::File;
use std::path::{Path, PathBuf};

use pcap_file::pcap::PcapReader;
use pcap_file::pcapng::PcapNgReader;
use pcap_file::pcapng::blocks::interface_description::{
    InterfaceDescriptionBlock, InterfaceDescriptionOption,
};
use pcap_file::{DataLink, Endianness, PcapError, TsResolution};

use crate::base::{Error, Result};
use crate::input::start::open_file;

/// First bytes of a capture. pcap: either byte order, microseconds or nanoseconds; the last is pcapng's.
pub(super) const MAGICS: [&[u8]; 5] = [
    &[0xd4, 0xc3, 0xb2, 0xa1],
    &[0xa1, 0xb2, 0xc3, 0xd4],
    &[0x4d, 0x3c, 0xb2, 0xa1],
    &[0xa1, 0xb2, 0x3c, 0x4d],
    PCAPNG_MAGIC,
];

const PCAPNG_MAGIC: &[u8] = &[0x0a, 0x0d, 0x0d, 0x0a];

/// Types of a pcapng file's blocks.
const PACKET_BLOCK: u32 = 2;
const SIMPLE_PACKET_BLOCK: u32 = 3;
const ENHANCED_PACKET_BLOCK: u32 = 6;

/// Bytes of an enhanced packet block before its data; the obsolete packet block has as many.
const PACKET_HEADER: usize = 20;

/// The links whose packets are read.
const LINKS: &str = "Ethernet, Linux SLL and SLL2, raw IP and loopback";

/// Units of time in a second where an interface of a pcapng file does not say.
const MICROSECONDS: u128 = 1_000_000;

/// What a capture holds at one place.
pub(super) enum Captured {
    Packet {
        stamp_ns: u64,
        link: DataLink,
        data: Vec<u8>,
    },
    /// A packet that cannot be used, and why.
    Unusable(&'static str),
    /// The file is cut off or damaged from here on.
    Cut,
}

enum Form {
    Pcap(PcapReader<File>),
    PcapNg(PcapNgReader<File>),
}

/// See the module.
pub(super) struct Capture {
    path: PathBuf,
    form: Form,
}

impl Capture {
    /// # Errors
    /// [`Error::File`]; [`Error::Format`] for other files, and for a pcap file whose link carries no IP.
    pub(super) fn open(path: &Path, start: &[u8]) -> Result<Self> {
        let file = open_file(path)?;
        let format = |reason: String| Error::Format { path: path.into(), reason };
        let form = if start.starts_with(PCAPNG_MAGIC) {
            let reader = PcapNgReader::new(file);
            Form::PcapNg(reader.map_err(|error| format(format!("is no pcapng file: {error}")))?)
        } else {
            let reader = PcapReader::new(file);
            let reader = reader.map_err(|error| format(format!("is no pcap file: {error}")))?;
            let link = reader.header().datalink;
            if !carries_ip(link) {
                return Err(format(format!("its link type {link:?} is none of {LINKS}")));
            }
            Form::Pcap(reader)
        };
        Ok(Self { path: path.into(), form })
    }

    /// What comes next; `None` at the end.
    ///
    /// # Errors
    /// [`Error::File`] where the operating system fails to read.
    pub(super) fn next(&mut self) -> Result<Option<Captured>> {
        let next = match &mut self.form {
            Form::Pcap(reader) => next_of_pcap(reader),
            Form::PcapNg(reader) => next_of_pcapng(reader),
        };
        match next {
            Ok(captured) => Ok(captured),
            Err(PcapError::IoError(error)) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
                Err(Error::File { path: self.path.clone(), source: error })
            }
            Err(_) => Ok(Some(Captured::Cut)),
        }
    }
}

fn carries_ip(link: DataLink) -> bool {
    matches!(link, DataLink::ETHERNET | DataLink::RAW | DataLink::IPV4 | DataLink::IPV6)
        || matches!(link, DataLink::LINUX_SLL | DataLink::LINUX_SLL2 | DataLink::NULL | DataLink::LOOP)
}

fn next_of_pcap(reader: &mut PcapReader<File>) -> Result<Option<Captured>, PcapError> {
    let header = reader.header();
    let Some(packet) = reader.next_raw_packet() else { return Ok(None) };
    let packet = packet?;
    let unit_ns = if header.ts_resolution == TsResolution::NanoSecond { 1 } else { 1000 };
    Ok(Some(Captured::Packet {
        stamp_ns: u64::from(packet.ts_sec) * 1_000_000_000 + u64::from(packet.ts_frac) * unit_ns,
        link: header.datalink,
        data: packet.data.into_owned(),
    }))
}

/// Blocks that hold no packet are gone through.
fn next_of_pcapng(reader: &mut PcapNgReader<File>) -> Result<Option<Captured>, PcapError> {
    loop {
        let Some(block) = reader.next_raw_block() else { return Ok(None) };
        let block = block?;
        let kind = block.type_;
        match kind {
            ENHANCED_PACKET_BLOCK | PACKET_BLOCK => {
                let body = block.body.into_owned();
                return packet(&body, kind, reader).map(Some);
            }
            SIMPLE_PACKET_BLOCK => return Ok(Some(Captured::Unusable("a packet without a time"))),
            _ => {}
        }
    }
}

/// The packet in a block's body: interface (of the obsolete block two bytes, and two that count drops), upper and lower
/// half of the time, bytes captured, bytes on the wire, data.
fn packet(body: &[u8], kind: u32, reader: &PcapNgReader<File>) -> Result<Captured, PcapError> {
    let big = reader.section().endianness == Endianness::Big;
    let Some((head, data)) = body.split_first_chunk::<PACKET_HEADER>() else {
        return Err(PcapError::InvalidField("a packet block is shorter than its header"));
    };
    let number = |at: usize| {
        let [a, b, c, d] = [head[at], head[at + 1], head[at + 2], head[at + 3]];
        if big { u32::from_be_bytes([a, b, c, d]) } else { u32::from_le_bytes([a, b, c, d]) }
    };
    let interface = match kind {
        PACKET_BLOCK if big => number(0) >> 16,
        PACKET_BLOCK => number(0) & 0xffff,
        _ => number(0),
    };
    let Some(interface) = reader.interfaces().get(interface as usize) else {
        return Ok(Captured::Unusable("a packet of an interface that the capture does not describe"));
    };
    if !carries_ip(interface.linktype) {
        return Ok(Captured::Unusable("a packet of a link that carries no IP"));
    }
    let time = u64::from(number(4)) << 32 | u64::from(number(8));
    let Some(stamp_ns) = stamp_ns(time, interface) else {
        return Ok(Captured::Unusable("a packet whose time is not between the years 1970 and 2554"));
    };
    let Some(data) = data.get(..number(12) as usize) else {
        return Err(PcapError::InvalidField("a packet is longer than its block"));
    };
    Ok(Captured::Packet { stamp_ns, link: interface.linktype, data: data.into() })
}

/// Nanoseconds since 1970 of a time in the interface's units (option `if_tsresol`: a power of ten or, with the upper bit
/// set, of two; microseconds where it is missing) after its offset (`if_tsoffset`, signed seconds).
fn stamp_ns(time: u64, interface: &InterfaceDescriptionBlock<'_>) -> Option<u64> {
    let (mut units_in_second, mut offset_s) = (Some(MICROSECONDS), 0);
    for option in &interface.options {
        match option {
            InterfaceDescriptionOption::IfTsResol(power) if power & 0x80 == 0 => {
                units_in_second = 10_u128.checked_pow(u32::from(*power));
            }
            InterfaceDescriptionOption::IfTsResol(power) => {
                units_in_second = Some(1_u128 << (power & 0x7f));
            }
            InterfaceDescriptionOption::IfTsOffset(seconds) => offset_s = seconds.cast_signed(),
            _ => {}
        }
    }
    // A time of 64 bits in units that are too small for 128 is less than a nanosecond.
    let after_offset_ns = units_in_second.map_or(0, |units| u128::from(time) * 1_000_000_000 / units);
    let offset_ns = i128::from(offset_s) * 1_000_000_000;
    u64::try_from(i128::try_from(after_offset_ns).ok()?.checked_add(offset_ns)?).ok()
}
