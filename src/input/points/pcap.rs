//! Captures of a Velodyne sensor's network packets (pcap).

use std::fs::File;
use std::path::{Path, PathBuf};

use etherparse::{SlicedPacket, TransportSlice};
use pcap_file::pcap::{PcapReader, RawPcapPacket};
use pcap_file::{DataLink, PcapError, TsResolution};

use crate::base::{Error, Result};
use crate::input::points::velodyne::{Cut, Decoder, PACKET_BYTES};
use crate::input::points::{Options, ScanReport, Scans};
use crate::sensor::Scan;

/// First bytes of a capture: either byte order, microseconds or nanoseconds.
pub(super) const MAGICS: [&[u8]; 4] = [
    &[0xd4, 0xc3, 0xb2, 0xa1],
    &[0xa1, 0xb2, 0xc3, 0xd4],
    &[0x4d, 0x3c, 0xb2, 0xa1],
    &[0xa1, 0xb2, 0x3c, 0x4d],
];

/// UDP port of data packets.
const DATA_PORT: u16 = 2368;

/// UDP port of position packets, which hold no points.
const POSITION_PORT: u16 = 8308;

/// Frame of points whose recording does not say.
const FRAME: &str = "velodyne";

/// Reads the data packets (UDP port 2368, 1206 bytes) of a capture; see [`Scans`]. The frame is `velodyne`.
pub struct PcapScans {
    path: PathBuf,
    source: String,
    packets: PcapReader<File>,
    decoder: Decoder,
    seen_data: bool,
    at_end: bool,
    report: ScanReport,
}

impl PcapScans {
    /// Opens a capture.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Format`] for files that are no pcap and for links that carry no IP.
    pub fn open(path: &Path, options: &Options) -> Result<Self> {
        let file = File::open(path).map_err(Error::file(path))?;
        let format = |reason: String| Error::Format { path: path.into(), reason };
        let packets = PcapReader::new(file).map_err(|error| format(format!("is no pcap file: {error}")))?;
        let link = packets.header().datalink;
        if !matches!(link, DataLink::ETHERNET | DataLink::RAW | DataLink::LINUX_SLL | DataLink::NULL) {
            return Err(format(format!(
                "its link type {link:?} is none of Ethernet, Linux SLL, raw IP and loopback"
            )));
        }
        let source = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Ok(Self {
            path: path.into(),
            decoder: Decoder::new(&source, FRAME, options),
            source,
            packets,
            seen_data: false,
            at_end: false,
            report: ScanReport::default(),
        })
    }

    /// Takes in one packet, or the end of the file.
    fn step(&mut self) -> Result<()> {
        let header = self.packets.header();
        match self.packets.next_raw_packet() {
            Some(Ok(packet)) => {
                let stamp_ns = stamp_ns(&packet, header.ts_resolution);
                match payload(&packet.data, header.datalink) {
                    Ok(payload) => {
                        self.seen_data = true;
                        self.decoder.push(payload, stamp_ns, Cut::AtWrap, &mut self.report.read);
                    }
                    Err(reason) => self.report.read.skip(&self.source, reason, stamp_ns),
                }
                return Ok(());
            }
            Some(Err(PcapError::IoError(error))) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
                return Err(Error::File { path: self.path.clone(), source: error });
            }
            Some(Err(_)) => {
                let note = "the file is cut off or damaged within a packet; what comes before was read";
                self.report.read.note(note);
            }
            None => {}
        }
        self.at_end = true;
        self.decoder.finish(&mut self.report.read);
        if self.seen_data {
            return Ok(());
        }
        let skipped = &self.report.read.skipped;
        let others: Vec<String> =
            skipped.iter().take(8).map(|skip| format!("{} of {}", skip.count, skip.reason)).collect();
        let others = if others.is_empty() { "no packets at all".into() } else { others.join(", ") };
        let reason = format!(
            "holds no Velodyne data packets (UDP port {DATA_PORT}, {PACKET_BYTES} bytes), but {others}"
        );
        Err(Error::Format { path: self.path.clone(), reason })
    }
}

fn stamp_ns(packet: &RawPcapPacket, resolution: TsResolution) -> u64 {
    let unit_ns = if resolution == TsResolution::NanoSecond { 1 } else { 1000 };
    u64::from(packet.ts_sec) * 1_000_000_000 + u64::from(packet.ts_frac) * unit_ns
}

/// The payload of a packet to the data port, or what the packet is in its place.
fn payload(bytes: &[u8], link: DataLink) -> std::result::Result<&[u8], String> {
    let sliced = match link {
        DataLink::ETHERNET => SlicedPacket::from_ethernet(bytes),
        DataLink::LINUX_SLL => SlicedPacket::from_linux_sll(bytes),
        DataLink::NULL => SlicedPacket::from_ip(bytes.get(4..).unwrap_or_default()),
        _ => SlicedPacket::from_ip(bytes),
    };
    let sliced = sliced.map_err(|_| String::from("a packet that is cut short or damaged"))?;
    let Some(TransportSlice::Udp(udp)) = sliced.transport else {
        return Err("a packet other than UDP".into());
    };
    match (udp.destination_port(), udp.payload()) {
        (DATA_PORT, payload) if payload.len() == PACKET_BYTES => Ok(payload),
        (DATA_PORT, payload) => Err(format!("UDP of {} bytes on port {DATA_PORT}", payload.len())),
        (POSITION_PORT, _) => Err(format!("position packet (UDP port {POSITION_PORT})")),
        (port, _) => Err(format!("UDP on port {port}")),
    }
}

impl Scans for PcapScans {
    fn next_scan(&mut self) -> Result<Option<Scan>> {
        loop {
            if let Some(mut scan) = self.decoder.pop() {
                if scan.points.is_empty() {
                    self.report.count_empty(&self.source, &scan);
                    continue;
                }
                self.report.count(&mut scan);
                return Ok(Some(scan));
            }
            if self.at_end {
                return Ok(None);
            }
            self.step()?;
        }
    }

    fn report(&self) -> &ScanReport {
        &self.report
    }

    fn scan_count_hint(&self) -> Option<u64> {
        None
    }
}
