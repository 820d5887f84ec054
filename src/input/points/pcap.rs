//! Captures of a Velodyne sensor's network packets (pcap, pcapng).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use etherparse::{SlicedPacket, TransportSlice};
use pcap_file::DataLink;

use crate::base::{Error, Result};
use crate::input::points::capture::{Capture, Captured};
use crate::input::points::velodyne::{Cut, Decoder, PACKET_BYTES};
use crate::input::points::{Options, ScanReport, Scans};
use crate::input::start::start_of;
use crate::sensor::Scan;

/// UDP port of data packets where none is stated.
pub(crate) const DATA_PORT: u16 = 2368;

/// UDP port of position packets, which hold no points.
const POSITION_PORT: u16 = 8308;

/// Bytes before the IP packet of a Linux SLL2 capture.
const SLL2_HEADER: usize = 20;

/// Frame of points whose recording does not say.
const FRAME: &str = "velodyne";

/// Ports that sensors whose packets are not decoded send to by default.
const OTHERS: [(u16, &str); 5] =
    [(7502, "Ouster"), (6699, "RoboSense"), (57_000, "Livox"), (56_301, "Livox"), (10_110, "Hesai")];

/// Reads the data packets (1206 bytes to UDP port 2368, or to that of [`Options::port`]) of a capture; see [`Scans`]. The frame is `velodyne`.
pub struct PcapScans {
    path: PathBuf,
    source: String,
    capture: Capture,
    decoder: Decoder,
    port: u16,
    seen_data: bool,
    /// Packets as large as data packets by the port that they go to.
    ports: BTreeMap<u16, u64>,
    at_end: bool,
    report: ScanReport,
}

impl PcapScans {
    /// Opens a capture.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Format`] for files that are no capture and for links that carry no IP.
    pub fn open(path: &Path, options: &Options) -> Result<Self> {
        let capture = Capture::open(path, &start_of(path)?)?;
        let source = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        Ok(Self {
            path: path.into(),
            decoder: Decoder::new(&source, FRAME, options),
            source,
            capture,
            port: options.port.unwrap_or(DATA_PORT),
            seen_data: false,
            ports: BTreeMap::new(),
            at_end: false,
            report: ScanReport::default(),
        })
    }

    /// Takes in one packet, or the end of the file.
    fn step(&mut self) -> Result<()> {
        match self.capture.next()? {
            Some(Captured::Packet { stamp_ns, link, data }) => {
                match udp(&data, link).map(|(port, payload)| (port, payload.to_vec())) {
                    Ok((port, payload)) => self.take(port, &payload, stamp_ns),
                    Err(reason) => self.report.read.skip(&self.source, reason, stamp_ns),
                }
                return Ok(());
            }
            Some(Captured::Unusable(reason)) => {
                self.report.read.skip(&self.source, reason, 0);
                return Ok(());
            }
            Some(Captured::Cut) => {
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
        let port = self.port;
        let hint = self.hint();
        let reason = format!(
            "holds no Velodyne data packets (UDP port {port}, {PACKET_BYTES} bytes), but {others}{hint}"
        );
        Err(Error::Format { path: self.path.clone(), reason })
    }

    fn take(&mut self, port: u16, payload: &[u8], stamp_ns: u64) {
        if payload.len() == PACKET_BYTES {
            *self.ports.entry(port).or_default() += 1;
            if port == self.port {
                self.seen_data = true;
                self.decoder.push(payload, stamp_ns, Cut::AtWrap, &mut self.report.read);
                return;
            }
        }
        let reason = match (port, OTHERS.iter().find(|(other, _)| *other == port)) {
            _ if port == self.port => format!("UDP of {} bytes on port {port}", payload.len()),
            (POSITION_PORT, _) => format!("position packet (UDP port {POSITION_PORT})"),
            (_, Some((_, maker))) => {
                format!("UDP on port {port}, as {maker} sensors send, whose packets are not decoded")
            }
            _ => format!("UDP on port {port}"),
        };
        self.report.read.skip(&self.source, reason, stamp_ns);
    }

    /// Which other ports data may have gone to.
    fn hint(&self) -> String {
        let ports: Vec<String> = self.ports.iter().map(|(port, count)| format!("{port} ({count})")).collect();
        match self.ports.keys().next() {
            Some(first) => format!(
                "; packets of {PACKET_BYTES} bytes go to port {}: --port {first} takes these (`velodyne_port`)",
                ports.join(", ")
            ),
            None => String::new(),
        }
    }
}

/// Destination port and payload of a UDP packet, or what the packet is in its place.
fn udp(bytes: &[u8], link: DataLink) -> std::result::Result<(u16, &[u8]), String> {
    let sliced = match link {
        DataLink::ETHERNET => SlicedPacket::from_ethernet(bytes),
        DataLink::LINUX_SLL => SlicedPacket::from_linux_sll(bytes),
        DataLink::LINUX_SLL2 => SlicedPacket::from_ip(bytes.get(SLL2_HEADER..).unwrap_or_default()),
        DataLink::NULL | DataLink::LOOP => SlicedPacket::from_ip(bytes.get(4..).unwrap_or_default()),
        _ => SlicedPacket::from_ip(bytes),
    };
    let sliced = sliced.map_err(|_| String::from("a packet that is cut short or damaged"))?;
    match sliced.transport {
        Some(TransportSlice::Udp(udp)) => Ok((udp.destination_port(), udp.payload())),
        _ => Err("a packet other than UDP".into()),
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
