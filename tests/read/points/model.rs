//! Which model packets are of, and packets that are refused.

use limpid::input::ReadReport;
use limpid::input::points::Options;
use limpid::input::points::velodyne::{Cut, Decoder, Packet};
use limpid::sensor::Scan;
use limpid::sensor::VelodyneModel as Model;

use super::make::{HDL32E, STRONGEST, VLP16, packet, turning};
use super::refused;
use super::velodyne::decode;
use crate::read::synthetic::at_ms;

fn rings(scans: &[Scan]) -> u16 {
    scans.iter().flat_map(|scan| &scan.points).map(|point| point.ring + 1).max().unwrap()
}

#[test]
fn timing_decides_where_the_factory_byte_contradicts_it() {
    let (scans, report) = decode(&turning(40, HDL32E), None);
    let (expected, _) = decode(&turning(40, VLP16), None);
    assert!(scans == expected, "decoded as the VLP-16 that it is");
    assert_eq!(report.notes.len(), 1, "{report:?}");
    let parts = ["0x21", "says HDL-32E", "110.6 us", "decoded as VLP-16"];
    assert!(parts.iter().all(|part| report.notes[0].contains(part)), "{report:?}");
}

#[test]
fn a_stated_model_is_taken_for_granted() {
    let (scans, report) = decode(&turning(40, VLP16), Some(Model::Hdl32e));
    assert_eq!(rings(&scans), 32);
    assert!(report.notes.is_empty());
    assert_eq!(rings(&decode(&turning(40, VLP16), None).0), 16);
}

#[test]
fn one_packet_is_of_the_model_that_it_names() {
    let (scans, report) = decode(&turning(1, HDL32E), None);
    assert_eq!((rings(&scans), report.notes.len()), (32, 0));
}

#[test]
fn timing_of_no_model_is_told() {
    let mut packets = turning(40, VLP16);
    for (number, packet) in packets.iter_mut().enumerate() {
        packet[1200..1204].copy_from_slice(&(2000 * number as u32).to_le_bytes());
    }
    let (scans, report) = decode(&packets, None);
    assert_eq!(rings(&scans), 16);
    assert!(report.notes[0].contains("fits no model: decoded as VLP-16"), "{report:?}");
}

#[test]
fn unknown_models_are_refused_by_their_byte() {
    let (scans, report) = decode(&turning(40, 0xa1), None);
    assert!(scans.is_empty());
    assert_eq!(report.skipped.len(), 1, "{report:?}");
    assert_eq!(report.skipped[0].count, 40);
    assert!(report.skipped[0].reason.contains("0xa1 names no model"), "{report:?}");
    assert_eq!(rings(&decode(&turning(40, 0xa1), Some(Model::Vlp16)).0), 16, "but for a stated model");
}

#[test]
fn packets_of_another_sensor_are_counted() {
    let mut packets = turning(40, VLP16);
    packets[30][1205] = HDL32E;
    let (scans, report) = decode(&packets, None);
    assert_eq!(scans[0].points.len(), 39 * 384);
    assert!(report.skipped[0].reason.contains("0x21 after 0x22"), "{report:?}");
}

#[test]
fn bad_packets_are_refused_by_name() {
    let good = packet([0; 12], 0, [STRONGEST, VLP16], |_, _| (1, 1));
    let changed = |at: usize, value: u8| {
        let mut bytes = good.clone();
        bytes[at] = value;
        bytes
    };
    assert!(Packet::new(&good).is_ok());
    refused(Packet::new(&good[..1205]), &["1205 bytes in place of 1206"]);
    refused(Packet::new(&[]), &["0 bytes"]);
    refused(Packet::new(&[good.clone(), vec![0]].concat()), &["1207 bytes"]);
    refused(Packet::new(&changed(1204, 0x40)), &["return mode 0x40"]);
    refused(Packet::new(&changed(500, 0xdd)), &["0xff 0xee"]);
    refused(Packet::new(&changed(103, 0xff)), &["beyond 360 degrees"]);
    let (mut decoder, mut report) = (Decoder::new("port", "", &Options::default()), ReadReport::default());
    for bytes in [&good[..1205], &changed(1204, 0x40), &changed(1204, 0x40), &good] {
        decoder.push(bytes, at_ms(0), Cut::AtWrap, &mut report);
    }
    decoder.finish(&mut report);
    assert_eq!(decoder.pop().unwrap().points.len(), 384);
    assert_eq!(report.skipped.iter().map(|skip| skip.count).collect::<Vec<_>>(), [1, 2]);
}
