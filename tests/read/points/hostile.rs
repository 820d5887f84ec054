//! Random and changed input: errors or scans of finite points in bounded memory, never a panic. The targets in `fuzz/` run
//! the same properties for longer.

use limpid::input::ReadReport;
use limpid::input::points::velodyne::{Cut, Decoder, ScanMessage};
use limpid::input::points::{Options, cloud, laser, livox, pcd, ply};
use limpid::message::foxglove;
use limpid::message::foxglove::decode_protobuf;
use limpid::message::lidar::{CustomMsg, CustomPoint, LaserEcho, LaserScan, MultiEchoLaserScan};
use limpid::message::ros1;
use limpid::message::ros2::{Header, PointCloud2, PointField, decode_cdr, encode_cdr};
use limpid::sensor::Scan;
use limpid::sensor::VelodyneModel as Model;
use prop::collection::vec;
use proptest::prelude::*;

use super::make::{DUAL, VLP16, XYZI, capture_packets, cloud as make_cloud, packet, scan_message, turning};
use super::read_bytes;
use crate::read::synthetic::at_ms;

/// Points take a byte of the source each, at least, and all their values are finite.
fn sound(scan: limpid::Result<Scan>, bytes: usize) -> bool {
    scan.map_or(true, |scan| {
        let finite = |values: &[f32]| values.iter().all(|value| value.is_finite());
        let points = scan.points.iter();
        scan.points.len() <= bytes
            && points
                .clone()
                .all(|point| finite(&point.position_m()) && finite(&[point.intensity, point.time_s]))
    })
}

fn decode_all(bytes: &[u8]) -> bool {
    let (options, size) = (Options::default(), bytes.len());
    let cdr = decode_cdr("", bytes).and_then(|message| cloud::from_ros(message, &options));
    let ros1 = ros1::decode("", bytes).and_then(|message| cloud::from_ros(message, &options));
    let foxglove = decode_protobuf::<foxglove::PointCloud>("", bytes);
    let foxglove = foxglove.and_then(|message| cloud::from_foxglove(&message, &options));
    let files = [ply::read(bytes, 0, &options), pcd::read(bytes, 0, &options)];
    let packets = [ScanMessage::from_cdr(bytes), ScanMessage::from_ros1(bytes)];
    let bounded =
        |message: limpid::Result<ScanMessage>| message.map_or(0, |m| m.packets.len()) * 1214 <= size;
    let flat = [decode_cdr("", bytes), ros1::decode("", bytes)]
        .map(|message| message.and_then(laser::from_laser_scan));
    let multi = [decode_cdr("", bytes), ros1::decode("", bytes)]
        .map(|message| message.and_then(laser::from_multi_echo));
    let livox = [decode_cdr("", bytes), ros1::decode("", bytes)]
        .map(|message| message.and_then(livox::from_custom_msg));
    let lidars = flat.into_iter().chain(multi).chain(livox);
    [cdr, ros1, foxglove].into_iter().chain(files).chain(lidars).all(|scan| sound(scan, size))
        && packets.into_iter().all(bounded)
}

fn changed(mut bytes: Vec<u8>, changes: &[(prop::sample::Index, u8)]) -> Vec<u8> {
    for (at, value) in changes {
        let at = at.index(bytes.len());
        bytes[at] = *value;
    }
    bytes
}

fn field() -> impl Strategy<Value = PointField> {
    let name = prop::sample::select(vec!["x", "y", "z", "intensity", "ring", "time", "return_type", "label"]);
    (name, any::<u32>(), 0..10_u8, any::<bool>()).prop_map(|(name, offset, datatype, small)| {
        let offset = if small { offset % 24 } else { offset };
        PointField { name: name.into(), offset, datatype, count: 1 }
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_are_no_scans(mut bytes in vec(any::<u8>(), 0..400), start in 0..6_usize) {
        let starts: [&[u8]; 6] = [
            b"",
            &[0, 1, 0, 0],
            &[0, 0, 0, 0],
            b"ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty float x\n",
            b"VERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\n",
            b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nend_header\n",
        ];
        bytes.splice(0..0, starts[start].iter().copied());
        prop_assert!(decode_all(&bytes));
    }

    #[test]
    fn clouds_of_random_layouts_do_not_panic(
        sizes in any::<[u32; 4]>(),
        small in any::<[bool; 4]>(),
        fields in vec(field(), 0..10),
        big_endian in any::<bool>(),
        data in vec(any::<u8>(), 0..600),
    ) {
        let pick = |at: usize| if small[at] { sizes[at] % 33 } else { sizes[at] };
        let mut message = make_cloud(XYZI, pick(0), pick(1), data);
        message.fields.extend(fields);
        (message.height, message.row_step, message.is_bigendian) = (pick(2), pick(3), big_endian.into());
        let bytes = message.data.len();
        prop_assert!(sound(cloud::from_ros(message, &Options::default()), bytes));
    }

    #[test]
    fn changed_messages_and_files_do_not_panic(changes in vec((any::<prop::sample::Index>(), any::<u8>()), 1..12)) {
        let message: PointCloud2 = super::make::xyzi(&[[1.0; 4]; 5]);
        prop_assert!(decode_all(&changed(encode_cdr("", &message).unwrap(), &changes)));
        prop_assert!(decode_all(&changed(scan_message(0, &turning(2, VLP16), true), &changes)));
        prop_assert!(decode_all(&changed(scan_message(0, &turning(2, VLP16), false), &changes)));
        let pcd = b"VERSION 0.7\nFIELDS x y z i\nSIZE 4 4 4 4\nTYPE F F F F\nWIDTH 1\nHEIGHT 1\nPOINTS 1\nDATA ascii\n1 2 3 4\n";
        prop_assert!(decode_all(&changed(pcd.to_vec(), &changes)));
        let ply = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\n\
                    property float i\nend_header\n1 2 3 4\n";
        prop_assert!(decode_all(&changed(ply.to_vec(), &changes)));
    }

    #[test]
    fn changed_flat_scans_and_livox_clouds_do_not_panic(
        changes in vec((any::<prop::sample::Index>(), any::<u8>()), 0..12),
        cut in any::<prop::sample::Index>(),
        which in 0..3_usize,
    ) {
        let header = Header::new(at_ms(0), "lidar");
        let ranges = vec![1.0_f32; 40];
        let flat = LaserScan {
            header: header.clone(),
            angle_increment: 0.1,
            range_max: 9.0,
            ranges: ranges.clone(),
            intensities: ranges.clone(),
            ..LaserScan::default()
        };
        let multi = MultiEchoLaserScan {
            header: header.clone(),
            angle_increment: 0.1,
            range_max: 9.0,
            ranges: vec![LaserEcho { echoes: vec![1.0, 2.0] }; 20],
            intensities: vec![LaserEcho { echoes: vec![1.0, 2.0] }; 20],
            ..MultiEchoLaserScan::default()
        };
        let points = vec![CustomPoint { x: 1.0, ..CustomPoint::default() }; 20];
        let livox = CustomMsg { header, timebase: at_ms(0), point_num: 20, points, ..CustomMsg::default() };
        let bytes = match which {
            0 => encode_cdr("", &flat),
            1 => encode_cdr("", &multi),
            _ => encode_cdr("", &livox),
        };
        let bytes = changed(bytes.unwrap(), &changes);
        let cut = bytes.len() - cut.index(bytes.len() / 4);
        prop_assert!(decode_all(&bytes[..cut]));
    }

    #[test]
    fn changed_captures_do_not_panic(changes in vec((any::<prop::sample::Index>(), any::<u8>()), 1..12), cut in any::<prop::sample::Index>()) {
        let bytes = changed(capture_packets(&turning(4, VLP16)), &changes);
        let bytes = &bytes[..cut.index(bytes.len())];
        if let Ok((scans, report)) = read_bytes("changed.pcap", bytes) {
            prop_assert!(report.points <= 4 * 384 && scans.len() as u64 == report.scans);
        }
    }

    #[test]
    fn random_packets_do_not_panic(
        azimuths in vec(any::<[u16; 12]>(), 1..30),
        times in vec(any::<u32>(), 30),
        wild in any::<bool>(),
        distance in any::<u16>(),
        model in prop::sample::select(vec![None, Some(Model::Vlp16), Some(Model::Vlp32c)]),
    ) {
        let options = Options { model, ..Options::default() };
        let (mut decoder, mut report) = (Decoder::new("", "", &options), ReadReport::default());
        let mut points = 0;
        for (number, azimuths) in azimuths.iter().enumerate() {
            let azimuths = azimuths.map(|azimuth| if wild { azimuth } else { azimuth % 36_001 });
            let packet = packet(azimuths, times[number], [DUAL, VLP16], |block, channel| {
                (distance.wrapping_mul((block * 32 + channel) as u16), 1)
            });
            decoder.push(&packet, at_ms(0), Cut::AtWrap, &mut report);
        }
        decoder.finish(&mut report);
        while let Some(scan) = decoder.pop() {
            points += scan.points.len();
            prop_assert!(sound(Ok(scan), usize::MAX));
        }
        prop_assert!(points <= azimuths.len() * 384);
    }
}
