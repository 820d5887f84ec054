//! Revolutions that do not end, and sensors that do not turn as they should.

use super::make::{STRONGEST, VLP16, packet, turning};
use super::velodyne::decode;

/// Most packets of a scan, as the decoder documents.
const MOST: usize = 1024;

#[test]
fn a_sensor_that_stands_still_is_cut_by_packets() {
    let packets: Vec<Vec<u8>> =
        (0..3000).map(|_| packet([777; 12], 5, [STRONGEST, VLP16], |_, _| (5000, 1))).collect();
    let (scans, report) = decode(&packets, None);
    let counts: Vec<usize> = scans.iter().map(|scan| scan.points.len() / 384).collect();
    assert_eq!(counts, [MOST, MOST, 3000 - 2 * MOST]);
    assert_eq!(report.skipped.len(), 1, "{report:?}");
    assert!(report.skipped[0].count == 2 && report.skipped[0].reason.contains("does not end"), "{report:?}");
}

#[test]
fn a_pause_ends_a_revolution() {
    let mut packets = turning(40, VLP16);
    for packet in &mut packets[20..] {
        let time_us = u32::from_le_bytes(packet[1200..1204].try_into().unwrap()) + 2_000_000;
        packet[1200..1204].copy_from_slice(&time_us.to_le_bytes());
    }
    let (scans, _) = decode(&packets, None);
    assert_eq!(scans.iter().map(|scan| scan.points.len()).collect::<Vec<_>>(), [20 * 384, 20 * 384]);
}

#[test]
fn a_gap_in_the_field_of_view_does_not_bend_the_beams_beside_it() {
    // The azimuth jumps by 90 degrees within the packet; the second sequence of block 0 is 0.2 degrees on.
    let azimuths = std::array::from_fn(|block| 40 * block as u16 + if block > 5 { 9000 } else { 0 });
    let (scans, _) = decode(&[packet(azimuths, 0, [STRONGEST, VLP16], |_, _| (5000, 1))], None);
    let point = &scans[0].points[16];
    let azimuth_deg = f64::from(-point.y_m).atan2(point.x_m.into()).to_degrees();
    assert!((azimuth_deg - 0.2).abs() < 0.01, "{azimuth_deg}");
}
