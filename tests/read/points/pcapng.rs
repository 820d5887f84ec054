//! pcapng captures, made byte by byte: the scans of the same packets in a pcap file.

use limpid::sensor::Scan;
use prop::collection::vec;
use proptest::prelude::*;

use super::make::{VLP16, capture, capture_packets, frame, turning};
use super::{read_bytes, refused};
use crate::read::synthetic::at_ms;

/// Bytes as one byte order has them.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Order {
    Little,
    Big,
}

impl Order {
    fn u16(self, value: u16) -> [u8; 2] {
        if self == Self::Big { value.to_be_bytes() } else { value.to_le_bytes() }
    }

    fn u32(self, value: u32) -> [u8; 4] {
        if self == Self::Big { value.to_be_bytes() } else { value.to_le_bytes() }
    }

    fn block(self, kind: u32, body: &[u8]) -> Vec<u8> {
        let padded = body.len().next_multiple_of(4);
        let length = self.u32(padded as u32 + 12);
        let mut bytes = [&self.u32(kind)[..], &length, body].concat();
        bytes.resize(8 + padded, 0);
        bytes.extend(length);
        bytes
    }

    fn section(self) -> Vec<u8> {
        self.block(
            0x0a0d_0d0a,
            &[&self.u32(0x1a2b_3c4d)[..], &self.u16(1), &self.u16(0), &[0xff; 8]].concat(),
        )
    }

    /// A description of an interface; options are code and value.
    fn interface(self, link: u16, options: Options) -> Vec<u8> {
        let mut body = [&self.u16(link)[..], &[0, 0], &self.u32(65535)].concat();
        for (code, value) in options {
            body.extend([self.u16(*code), self.u16(value.len() as u16)].concat());
            body.extend(*value);
            body.resize(body.len().next_multiple_of(4), 0);
        }
        body.extend([0; 4]);
        self.block(1, &body)
    }

    fn packet(self, interface: u32, time: u64, data: &[u8]) -> Vec<u8> {
        let numbers = [interface, (time >> 32) as u32, time as u32, data.len() as u32, data.len() as u32];
        let mut body = numbers.map(|number| self.u32(number)).concat();
        body.extend(data);
        self.block(6, &body)
    }
}

/// Options of an interface: code and value.
type Options<'a> = &'a [(u16, &'a [u8])];

const ETHERNET: u16 = 1;

fn packets() -> Vec<Vec<u8>> {
    turning(90, VLP16).iter().map(|packet| frame(2368, packet)).collect()
}

fn expected() -> Vec<Scan> {
    let (scans, _) = read_bytes("drive.pcap", &capture_packets(&turning(90, VLP16))).unwrap();
    assert!(scans.len() == 2 && scans[0].stamp_ns == at_ms(0));
    scans
}

/// Packets a millisecond apart, at times in units of which a second has `in_second`.
fn drive(order: Order, options: Options, in_second: u64) -> Vec<u8> {
    let mut bytes = [order.section(), order.interface(ETHERNET, options)].concat();
    for (number, packet) in packets().iter().enumerate() {
        let time = u128::from(at_ms(number as u64)) * u128::from(in_second) / 1_000_000_000;
        bytes.extend(order.packet(0, time as u64, packet));
    }
    bytes
}

#[test]
fn captures_of_every_byte_order_and_unit_of_time_are_read() {
    let units: [(Options, u64); 5] = [
        (&[], 1_000_000),
        (&[(9, &[6])], 1_000_000),
        (&[(9, &[9])], 1_000_000_000),
        (&[(9, &[3])], 1000),
        (&[(2, b"lidar"), (9, &[0x80 | 30])], 1 << 30),
    ];
    for order in [Order::Little, Order::Big] {
        for (options, in_second) in units {
            let (scans, report) = read_bytes("drive.pcapng", &drive(order, options, in_second)).unwrap();
            assert!(report.read.skipped.is_empty() && report.read.notes.is_empty(), "{report:?}");
            let off = |(a, b): (&Scan, &Scan)| a.stamp_ns.abs_diff(b.stamp_ns);
            assert!(scans.iter().zip(&expected()).map(off).max().unwrap() < 2, "{options:?}");
            assert!(
                scans.iter().zip(&expected()).all(|(a, b)| a.points == b.points),
                "{order:?} {options:?}"
            );
        }
    }
}

#[test]
fn an_offset_of_time_is_added() {
    let shift = |seconds: i64| drive(Order::Little, &[(14, &seconds.to_le_bytes())], 1_000_000);
    for seconds in [3600_i64, -600] {
        let (scans, _) = read_bytes("drive.pcapng", &shift(seconds)).unwrap();
        assert_eq!(scans[0].stamp_ns as i64 - at_ms(0) as i64, seconds * 1_000_000_000);
    }
    let text = "a packet whose time is not between the years 1970 and 2554";
    refused(read_bytes("drive.pcapng", &shift(-2_000_000_000)), &["90 of", text]);
}

#[test]
fn blocks_of_all_kinds_are_gone_through() {
    let order = Order::Little;
    let mut bytes = [order.section(), order.interface(ETHERNET, &[]), order.interface(105, &[])].concat();
    for (number, packet) in packets().iter().enumerate() {
        let time = at_ms(number as u64) / 1000;
        match number {
            // Statistics, names, a kind of its own, and another link.
            10 => bytes.extend(
                [order.block(5, &[0; 12]), order.block(4, &[0; 4]), order.block(0x0bad, &[1; 7])].concat(),
            ),
            20 => bytes.extend(order.packet(1, time, &[0; 60])),
            30 => bytes.extend(order.packet(7, time, &[0; 60])),
            40 => bytes.extend(order.block(3, &[&order.u32(60)[..], &[0; 60]].concat())),
            // A file that was put to another: interfaces are counted anew.
            50 => bytes.extend([order.section(), order.interface(ETHERNET, &[])].concat()),
            _ => {}
        }
        if number == 60 {
            // The obsolete packet block.
            let numbers = [(time >> 32) as u32, time as u32, packet.len() as u32, packet.len() as u32];
            let body =
                [&order.u16(0)[..], &order.u16(9), &numbers.map(|n| order.u32(n)).concat(), packet].concat();
            bytes.extend(order.block(2, &body));
        } else {
            bytes.extend(order.packet(0, time, packet));
        }
    }
    let (scans, report) = read_bytes("drive.pcapng", &bytes).unwrap();
    assert!(scans.iter().zip(&expected()).all(|(a, b)| a.points == b.points));
    let reasons: Vec<&str> = report.read.skipped.iter().map(|skip| skip.reason.as_str()).collect();
    let parts = ["carries no IP", "does not describe", "without a time"];
    assert!(
        reasons.len() == 3 && reasons.iter().zip(parts).all(|(reason, part)| reason.contains(part)),
        "{reasons:?}"
    );
}

#[test]
fn newer_links_of_linux_are_read() {
    // Protocol IPv4, then 18 bytes of where it came from; without Ethernet's 14.
    let sll2 = |frame: &Vec<u8>| [&[8, 0][..], &[0; 18], &frame[14..]].concat();
    let raw = |frame: &Vec<u8>| frame[14..].to_vec();
    let order = Order::Little;
    for (link, change) in [(276, &sll2 as &dyn Fn(&Vec<u8>) -> Vec<u8>), (101, &raw), (228, &raw)] {
        let mut bytes = [order.section(), order.interface(link, &[])].concat();
        for (number, packet) in packets().iter().map(change).enumerate() {
            bytes.extend(order.packet(0, at_ms(number as u64) / 1000, &packet));
        }
        let (scans, report) = read_bytes("drive.pcapng", &bytes).unwrap();
        assert!(scans.iter().zip(&expected()).all(|(a, b)| a.points == b.points), "{link}: {report:?}");
    }
}

#[test]
fn captures_that_are_cut_off_or_damaged_give_what_came_before() {
    let whole = drive(Order::Little, &[], 1_000_000);
    let (scans, report) = read_bytes("cut.pcapng", &whole[..whole.len() - 100]).unwrap();
    assert_eq!(scans.iter().map(|scan| scan.points.len()).sum::<usize>(), 89 * 384);
    assert!(report.read.notes.iter().any(|note| note.contains("cut off")), "{report:?}");
    let mut long = whole.clone();
    let at = whole.len() - 1300;
    long[at..].fill(0xff);
    let (scans, report) = read_bytes("damaged.pcapng", &long).unwrap();
    assert_eq!(scans.iter().map(|scan| scan.points.len()).sum::<usize>(), 88 * 384);
    assert!(report.read.notes.iter().any(|note| note.contains("damaged")), "{report:?}");
    refused(read_bytes("new.pcapng", &[0x0a, 0x0d, 0x0d, 0x0a, 0, 0, 0, 0]), &["is no pcapng file"]);
    refused(read_bytes("none.pcapng", &Order::Little.section()), &["no packets at all"]);
    refused(read_bytes("other.pcap", &capture(&[frame(7502, &[0; 9])])), &["no Velodyne data packets"]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn changed_captures_do_not_panic(
        changes in vec((any::<prop::sample::Index>(), any::<u8>()), 1..12),
        head in any::<bool>(),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut bytes = drive(if head { Order::Big } else { Order::Little }, &[(9, &[9])], 1_000_000_000);
        bytes.truncate(6000);
        for (at, value) in changes {
            let at = at.index(if head { 200 } else { bytes.len() });
            bytes[at] = value;
        }
        bytes.truncate(cut.index(bytes.len()) + 1);
        if let Ok((_, report)) = read_bytes("changed.pcapng", &bytes) {
            prop_assert!(report.points <= 5 * 384);
        }
    }
}
