//! Packets, captures and clouds made by the tests.

use std::time::Duration;

use limpid::input::points::velodyne::PACKET_BYTES;
use limpid::message::ros2::{Header, PointCloud2, PointField};
use pcap_file::pcap::{PcapPacket, PcapWriter};

use crate::read::ros1::{header, u32s};
use crate::read::synthetic::at_ms;

pub(super) const STRONGEST: u8 = 0x37;
pub(super) const LAST: u8 = 0x38;
pub(super) const DUAL: u8 = 0x39;

pub(super) const VLP16: u8 = 0x22;
pub(super) const HDL32E: u8 = 0x21;
pub(super) const VLP32C: u8 = 0x28;

/// A data packet whose blocks start at these azimuths; measurements by block and channel.
pub(super) fn packet(
    azimuths: [u16; 12],
    time_us: u32,
    [mode, byte]: [u8; 2],
    measured: impl Fn(usize, usize) -> (u16, u8),
) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (block, azimuth) in azimuths.into_iter().enumerate() {
        bytes.extend([0xff, 0xee]);
        bytes.extend(azimuth.to_le_bytes());
        for (distance, reflectivity) in (0..32).map(|channel| measured(block, channel)) {
            bytes.extend(distance.to_le_bytes());
            bytes.push(reflectivity);
        }
    }
    bytes.extend(time_us.to_le_bytes());
    bytes.extend([mode, byte]);
    assert_eq!(bytes.len(), PACKET_BYTES);
    bytes
}

/// Packets of a VLP-16 at ten turns a second in the strongest mode, all measurements 10 m, one after the other.
pub(super) fn turning(packets: usize, byte: u8) -> Vec<Vec<u8>> {
    let block_us = 110.592;
    (0..packets)
        .map(|number| {
            let start_us = number as f64 * 12.0 * block_us;
            let azimuth =
                |block: usize| ((start_us + block as f64 * block_us) * 0.36).round() as u64 % 36_000;
            let azimuths = std::array::from_fn(|block| azimuth(block) as u16);
            packet(azimuths, start_us.round() as u32, [STRONGEST, byte], |_, _| (5000, 100))
        })
        .collect()
}

/// UDP over IPv4 over Ethernet.
pub(super) fn frame(port: u16, payload: &[u8]) -> Vec<u8> {
    let udp_bytes = 8 + payload.len() as u16;
    let mut bytes = vec![0xff; 12];
    bytes.extend([8, 0, 0x45, 0]);
    bytes.extend((20 + udp_bytes).to_be_bytes());
    bytes.extend([0, 0, 0x40, 0, 64, 17, 0, 0, 192, 168, 1, 201, 255, 255, 255, 255]);
    bytes.extend([2368, port, udp_bytes, 0].iter().flat_map(|value| value.to_be_bytes()));
    bytes.extend(payload);
    bytes
}

/// A capture of frames, a millisecond apart.
pub(super) fn capture(frames: &[Vec<u8>]) -> Vec<u8> {
    let mut writer = PcapWriter::new(Vec::new()).unwrap();
    for (number, frame) in frames.iter().enumerate() {
        let time = Duration::from_nanos(at_ms(number as u64));
        writer.write_packet(&PcapPacket::new(time, frame.len() as u32, frame)).unwrap();
    }
    writer.into_writer()
}

pub(super) fn capture_packets(packets: &[Vec<u8>]) -> Vec<u8> {
    capture(&packets.iter().map(|packet| frame(2368, packet)).collect::<Vec<_>>())
}

/// `velodyne_msgs/VelodyneScan` in CDR or as ROS 1 has it, packets a millisecond apart from `at_ms(ms)` on.
pub(super) fn scan_message(ms: u64, packets: &[Vec<u8>], cdr: bool) -> Vec<u8> {
    let pad = |bytes: &mut Vec<u8>| {
        bytes.resize(if cdr { bytes.len().next_multiple_of(4) } else { bytes.len() }, 0)
    };
    let mut bytes = if cdr { vec![0, 1, 0, 0] } else { Vec::new() };
    // CDR's texts end in a zero, ROS 1's headers start with a sequence number.
    bytes.extend(if cdr {
        header(at_ms(ms), "velodyne\0")[4..].to_vec()
    } else {
        header(at_ms(ms), "/velodyne")
    });
    pad(&mut bytes);
    bytes.extend(u32s(&[packets.len()]));
    for (number, packet) in packets.iter().enumerate() {
        pad(&mut bytes);
        let stamp_ns = at_ms(ms + number as u64);
        bytes.extend(u32s(&[stamp_ns / 1_000_000_000, stamp_ns % 1_000_000_000].map(|part| part as usize)));
        bytes.extend(packet);
    }
    bytes
}

/// Fields of a cloud: name, offset, type (1 to 8 as ROS has it).
pub(super) type Fields<'a> = &'a [(&'a str, u32, u8)];

pub(super) const XYZI: Fields = &[("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 12, 7)];

pub(super) fn cloud(fields: Fields, point_step: u32, points: u32, data: Vec<u8>) -> PointCloud2 {
    let field = |&(name, offset, datatype): &(&str, u32, u8)| PointField {
        name: name.into(),
        offset,
        datatype,
        count: 1,
    };
    PointCloud2 {
        header: Header::new(at_ms(0), "/lidar"),
        height: 1,
        width: points,
        fields: fields.iter().map(field).collect(),
        is_bigendian: 0,
        point_step,
        row_step: points * point_step,
        data,
        is_dense: 1,
    }
}

/// Points x, y, z, intensity as 32-bit floats.
pub(super) fn xyzi(points: &[[f32; 4]]) -> PointCloud2 {
    let data = points.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    cloud(XYZI, 16, points.len() as u32, data)
}

/// A PCD file's LZF, of plain runs only.
pub(super) fn lzf_plain(bytes: &[u8]) -> Vec<u8> {
    bytes.chunks(32).flat_map(|run| [&[run.len() as u8 - 1], run].concat()).collect()
}
