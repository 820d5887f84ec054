//! Velodyne packets against values computed by hand from the manuals.

use limpid::input::ReadReport;
use limpid::input::points::Options;
use limpid::input::points::velodyne::{Cut, Decoder};
use limpid::sensor::VelodyneModel as Model;
use limpid::sensor::{DropReason, Point, ReturnType, Scan, Strength};

use super::make::{
    DUAL, HDL32E, LAST, STRONGEST, VLP16, VLP32C, capture, capture_packets, frame, packet, scan_message,
    turning,
};
use super::{read_bytes, refused};
use crate::read::ros1::{Bag, Compression};
use crate::read::synthetic::{Recorder, at_ms};

/// 32-bit floats of tens of metres.
const TOLERANCE_M: f32 = 2e-5;

const PACKETS: &str = "velodyne_msgs/msg/VelodyneScan";

/// The scans of packets that came at `at_ms(0)`.
pub(super) fn decode(packets: &[Vec<u8>], model: Option<Model>) -> (Vec<Scan>, ReadReport) {
    let options = Options { model, ..Options::default() };
    let (mut decoder, mut report) = (Decoder::new("packets", "velodyne", &options), ReadReport::default());
    packets.iter().for_each(|packet| decoder.push(packet, at_ms(0), Cut::AtWrap, &mut report));
    decoder.finish(&mut report);
    (std::iter::from_fn(|| decoder.pop()).collect(), report)
}

#[track_caller]
fn assert_at(point: &Point, expected_m: [f64; 3]) {
    for (found, expected) in point.position_m().into_iter().zip(expected_m) {
        assert!((found - expected as f32).abs() < TOLERANCE_M, "{point:?} against {expected_m:?}");
    }
}

/// Only that block and channel measures.
fn only(block: usize, channel: usize, measured: (u16, u8)) -> impl Fn(usize, usize) -> (u16, u8) {
    move |at, of| if (at, of) == (block, channel) { measured } else { (0, 77) }
}

#[test]
fn a_vlp16_beam_lands_where_the_manual_says() {
    // Azimuth 90 degrees is to the right; laser 15 looks up 15 degrees and fires 15 x 2.304 us after the block.
    let bytes = packet([9000; 12], 500, [STRONGEST, VLP16], only(3, 15, (5000, 42)));
    let (scans, report) = decode(&[bytes], None);
    assert!(report.skipped.is_empty() && report.notes.is_empty(), "{report:?}");
    let [scan] = &scans[..] else { panic!("{scans:?}") };
    let [point] = &scan.points[..] else { panic!("{scan:?}") };
    let up = 15.0_f64.to_radians();
    assert_at(point, [0.0, -10.0 * up.cos(), 10.0 * up.sin() - 0.04191 * up.tan()]);
    assert_eq!((point.intensity, point.ring, point.column), (42.0, 15, 6));
    assert_eq!((point.return_type, point.strength), (ReturnType::Single, Strength::Unknown));
    assert!((point.time_s - (3.0 * 110.592e-6 + 15.0 * 2.304e-6)).abs() < 1e-9, "{}", point.time_s);
    assert_eq!((scan.stamp_ns, scan.frame_id.as_str()), (at_ms(0), "velodyne"));
    assert_eq!(scan.dropped.count(DropReason::NoReturn), 12 * 32 - 1);
}

#[test]
fn the_second_firing_sequence_of_a_vlp16_block_has_turned_on() {
    // 0.4 degrees a block: the second sequence is 0.2 degrees on, and laser 0 fires at its start.
    let azimuths = std::array::from_fn(|block| 40 * block as u16);
    let bytes = packet(azimuths, 0, [LAST, VLP16], only(0, 16, (5000, 1)));
    let (scans, _) = decode(&[bytes], Some(Model::Vlp16));
    let (up, azimuth) = ((-15.0_f64).to_radians(), 0.2_f64.to_radians());
    let z = 10.0 * up.sin() - 0.04191 * up.tan();
    assert_at(&scans[0].points[0], [10.0 * up.cos() * azimuth.cos(), -10.0 * up.cos() * azimuth.sin(), z]);
    assert_eq!((scans[0].points[0].ring, scans[0].points[0].column), (0, 1));
}

#[test]
fn hdl32e_and_vlp32c_have_their_own_units_and_angles() {
    let bytes = packet([0; 12], 0, [STRONGEST, HDL32E], only(0, 0, (5000, 1)));
    let (scans, _) = decode(&[bytes], None);
    let up = (-30.67_f64).to_radians();
    assert_at(&scans[0].points[0], [10.0 * up.cos(), 0.0, 10.0 * up.sin() - 0.02883 * up.tan()]);
    // Laser 5 is level and points 1.4 degrees back; with laser 4 it fires third.
    let bytes = packet([0; 12], 0, [STRONGEST, VLP32C], only(0, 5, (5000, 1)));
    let (scans, _) = decode(&[bytes], None);
    let azimuth = (-1.4_f64).to_radians();
    assert_at(&scans[0].points[0], [20.0 * azimuth.cos(), -20.0 * azimuth.sin(), 0.0]);
    assert!((scans[0].points[0].time_s - 2.0 * 2.304e-6).abs() < 1e-9);
    assert_eq!(scans[0].points[0].ring, 20, "20 lasers look lower than level");
}

#[test]
fn a_dual_packet_holds_the_last_return_before_the_other() {
    let measured = |block: usize, channel: usize| match (block, channel) {
        (0, 1) | (1, 1) => (4000, 9),
        (0, 2) => (6000, 20),
        (1, 2) => (3000, 80),
        (0, 3) => (6000, 80),
        (1, 3) => (3000, 20),
        (0, 4) => (6000, 50),
        (1, 4) => (3000, 50),
        (0, 5) => (6000, 60),
        (1, 6) => (3000, 60),
        _ => (0, 0),
    };
    let azimuths = std::array::from_fn(|block| 40 * (block as u16 / 2));
    let (scans, _) = decode(&[packet(azimuths, 0, [DUAL, VLP16], measured)], None);
    let found: Vec<_> =
        scans[0].points.iter().map(|p| (p.ring, p.intensity, p.return_type, p.strength, p.column)).collect();
    use ReturnType::{Both, Last, StrongestOrSecond as Other};
    use Strength::{Equal, Stronger, Unknown, Weaker};
    let expected = [
        (8, 9.0, Both, Unknown, 0),
        (1, 20.0, Last, Weaker, 0),
        (1, 80.0, Other, Stronger, 0),
        (9, 80.0, Last, Stronger, 0),
        (9, 20.0, Other, Weaker, 0),
        (2, 50.0, Last, Equal, 0),
        (2, 50.0, Other, Equal, 0),
        (10, 60.0, Last, Unknown, 0),
        (3, 60.0, Other, Unknown, 0),
    ];
    assert_eq!(found, expected);
    assert_eq!(scans[0].dropped.count(DropReason::NoReturn) as usize + found.len() + 1, 12 * 32);
}

#[test]
fn revolutions_end_where_the_azimuth_wraps() {
    // 75.35 packets a turn.
    let (scans, report) = decode(&turning(160, VLP16), None);
    assert!(report.skipped.is_empty() && report.notes.is_empty(), "{report:?}");
    let counts: Vec<usize> = scans.iter().map(|scan| scan.points.len()).collect();
    assert_eq!(counts.iter().sum::<usize>(), 160 * 384);
    assert_eq!(scans.len(), 3);
    assert!(counts[..2].iter().all(|count| count.abs_diff(28_935) <= 32), "{counts:?}");
    for scan in &scans {
        assert!(
            scan.points[0].time_s == 0.0 && scan.points.iter().all(|p| (0.0..0.1001).contains(&p.time_s))
        );
        let columns = scan.points.iter().map(|point| point.column);
        assert!(columns.clone().is_sorted() && columns.max() == Some(scan.points.len() as u16 / 16 - 1));
    }
    // All packets came at once; the second scan starts in the midst of one.
    let started_s = (scans[1].stamp_ns - at_ms(0)) as f64 * 1e-9;
    assert!(started_s > 0.0 && started_s < 0.001_328, "{started_s}");
}

#[test]
fn the_sensors_clock_may_pass_the_hour() {
    let mut packets = turning(20, VLP16);
    for (number, packet) in packets.iter_mut().enumerate() {
        let time_us = (3_600_000_000_u64 - 13_271 + (number as f64 * 1327.104) as u64) % 3_600_000_000;
        packet[1200..1204].copy_from_slice(&(time_us as u32).to_le_bytes());
    }
    let (scans, report) = decode(&packets, None);
    assert!(report.skipped.is_empty() && report.notes.is_empty(), "{report:?}");
    let times: Vec<f32> = scans[0].points.iter().map(|point| point.time_s).collect();
    assert_eq!(scans.len(), 1);
    assert!(
        times.is_sorted_by(|a, b| b - a > -4e-5) && times[times.len() - 1] < 0.0266,
        "{:?}",
        times.last()
    );
}

#[test]
fn captures_give_data_packets_and_count_the_others() {
    let mut frames: Vec<Vec<u8>> = turning(80, VLP16).iter().map(|packet| frame(2368, packet)).collect();
    frames.insert(3, frame(8308, &[0; 512]));
    frames.insert(5, frame(2368, &[0; 1000]));
    frames.insert(7, frame(7777, &[0; 1206]));
    frames.insert(9, vec![0xff; 12]);
    let mut cut = frame(2368, &[0; 1206]);
    cut.truncate(600);
    frames.insert(11, cut);
    let (scans, report) = read_bytes("drive.pcap", &capture(&frames)).unwrap();
    assert_eq!((scans.len(), report.scans, report.points), (2, 2, 80 * 384));
    let reasons: Vec<&str> = report.read.skipped.iter().map(|skip| skip.reason.as_str()).collect();
    let expected = [
        "position packet (UDP port 8308)",
        "UDP of 1000 bytes on port 2368",
        "UDP on port 7777",
        "a packet that is cut short or damaged",
    ];
    assert_eq!(reasons, expected);
    assert_eq!(report.read.skipped[3].count, 2);
    assert!(report.read.skipped.iter().all(|skip| skip.source == "drive.pcap"));
    assert_eq!(scans[0].stamp_ns, at_ms(0));
}

#[test]
fn a_cut_off_capture_gives_what_came_before() {
    let whole = capture_packets(&turning(20, VLP16));
    let (scans, report) = read_bytes("cut.pcap", &whole[..whole.len() - 100]).unwrap();
    assert_eq!(scans[0].points.len(), 19 * 384);
    assert!(report.read.notes.iter().any(|note| note.contains("cut off")), "{report:?}");
    let (_, report) = read_bytes("whole.pcap", &whole).unwrap();
    assert!(report.read.notes.is_empty(), "{report:?}");
    refused(read_bytes("short.pcap", &whole[..20]), &["short.pcap", "is no pcap file"]);
}

#[test]
fn captures_without_data_packets_are_refused() {
    let ouster = capture(&[frame(7502, &[0; 900]), frame(7502, &[0; 900]), frame(7503, &[0; 48])]);
    let parts = [
        "ouster.pcap",
        "2 of UDP on port 7502, as Ouster sensors send",
        "1 of UDP on port 7503",
        "port 2368",
    ];
    refused(read_bytes("ouster.pcap", &ouster), &parts);
    refused(read_bytes("none.pcap", &capture(&[])), &["none.pcap", "no packets at all"]);
}

#[test]
fn a_message_with_a_revolution_is_a_scan() {
    // Cut by the driver a little after the azimuth wraps, twice.
    let packets = turning(153, VLP16);
    let parts = [&packets[1..77], &packets[77..153]];
    let mut recorder = Recorder::new();
    let mut bag = Bag::new(Compression::Lz4);
    for (part, ms) in parts.iter().zip([0, 100]) {
        recorder.bytes("/velodyne_packets", PACKETS, "cdr", at_ms(ms), &scan_message(ms, part, true));
        let message = scan_message(ms, part, false);
        bag.message("/velodyne_packets", "velodyne_msgs/VelodyneScan", at_ms(ms), &message);
    }
    for (name, bytes) in [("packets.mcap", recorder.finish()), ("packets.bag", bag.finish())] {
        let (scans, report) = read_bytes(name, &bytes).unwrap();
        let counts: Vec<usize> = scans.iter().map(|scan| scan.points.len()).collect();
        assert_eq!(counts, [76 * 384, 76 * 384], "{name}");
        assert_eq!(scans.iter().map(|scan| scan.index).collect::<Vec<_>>(), [0, 1]);
        assert_eq!(scans[1].stamp_ns, at_ms(100), "{name}");
        assert!(scans.iter().all(|scan| scan.frame_id == "velodyne"), "{name}");
        assert!(report.read.skipped.is_empty(), "{report:?}");
    }
}

#[test]
fn messages_with_less_than_a_revolution_are_joined() {
    let mut recorder = Recorder::new();
    for (number, part) in turning(160, VLP16).chunks(8).enumerate() {
        let ms = 10 * number as u64;
        recorder.bytes("/velodyne_packets", PACKETS, "cdr", at_ms(ms), &scan_message(ms, part, true));
    }
    let (scans, report) = read_bytes("parts.mcap", &recorder.finish()).unwrap();
    let (expected, _) = decode(&turning(160, VLP16), None);
    assert_eq!(scans.len(), 3);
    assert!(report.read.skipped.is_empty(), "{report:?}");
    for (scan, expected) in scans.iter().zip(&expected) {
        assert!(scan.points == expected.points, "scan {}", scan.index);
    }
}
