//! `limpid points` as a user meets it.

use std::path::Path;
use std::process::{Command, Output};

use limpid::input::points::Options;

use super::make::{HDL32E, VLP16, capture, capture_packets, frame, turning};
use super::read_all;

fn points(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_limpid")).arg("points").args(arguments).output().unwrap()
}

#[track_caller]
fn fails(output: &Output, code: i32, parts: &[&str]) {
    let text = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{text}");
    assert!(parts.iter().all(|part| text.contains(part)) && !text.contains("panicked"), "{text}");
}

fn file(folder: &Path, name: &str, bytes: &[u8]) -> String {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path.to_str().unwrap().into()
}

#[test]
fn every_revolution_is_a_ply_file() {
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "drive.pcap", &capture_packets(&turning(160, HDL32E)));
    let out = folder.path().join("scans");
    let output = points(&[&input, "-o", out.to_str().unwrap()]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{output:?}");
    let parts = ["3 scans, 61440 points", "decoded as VLP-16", "ms a scan"];
    assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    let header = std::fs::read(out.join("000001.ply")).unwrap();
    let start = "ply\nformat binary_little_endian 1.0\ncomment stamp_ns ";
    assert!(header.starts_with(start.as_bytes()));
    let properties = "property float x\nproperty float y\nproperty float z\nproperty float intensity\nproperty ushort ring\n\
                      property uchar return_type\nproperty float time_s\nend_header\n";
    assert!(String::from_utf8_lossy(&header).contains(properties));
    let (written, _) = read_all(&out, &Options::default()).unwrap();
    let (decoded, _) = read_all(input.as_ref(), &Options::default()).unwrap();
    assert_eq!(written.len(), 3);
    for (written, decoded) in written.iter().zip(&decoded) {
        let values = |points: &[limpid::sensor::Point]| {
            points.iter().map(|p| (p.position_m(), p.intensity, p.ring, p.time_s)).collect::<Vec<_>>()
        };
        assert!(values(&written.points) == values(&decoded.points));
    }
}

#[test]
fn limits_and_models_are_stated() {
    let folder = tempfile::tempdir().unwrap();
    let input = file(folder.path(), "drive.pcap", &capture_packets(&turning(160, VLP16)));
    let out = folder.path().join("scans");
    let output = points(&[&input, "-o", out.to_str().unwrap(), "--limit", "1", "--model", "hdl32e"]);
    assert!(String::from_utf8_lossy(&output.stdout).contains("1 scans, "), "{output:?}");
    let (written, _) = read_all(&out, &Options::default()).unwrap();
    assert_eq!(written.len(), 1);
    assert!(written[0].points.iter().any(|point| point.ring > 15));
    fails(
        &points(&[&input, "--model", "hdl64e"]),
        2,
        &["hdl64e", "vlp16", "puck-hi-res", "hdl32e", "vlp32c"],
    );
    fails(&points(&[]), 2, &["Usage"]);
}

#[test]
fn inputs_without_scans_fail_and_say_why() {
    let folder = tempfile::tempdir().unwrap();
    let unknown = file(folder.path(), "unknown.pcap", &capture_packets(&turning(3, 0xa1)));
    let output = points(&[&unknown]);
    fails(&output, 1, &["no scan with points"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains("skipped: 3 x unknown.pcap") && text.contains("0xa1 names no model"), "{text}");
    let other = file(folder.path(), "other.pcap", &capture(&[frame(7502, &[0; 9])]));
    fails(&points(&[&other]), 1, &["other.pcap", "no Velodyne data packets"]);
    fails(&points(&["Cargo.toml"]), 1, &["Cargo.toml", "no known format"]);
    fails(&points(&["no/such.pcap"]), 1, &["no/such.pcap"]);
    let good = file(folder.path(), "good.pcap", &capture_packets(&turning(3, VLP16)));
    fails(&points(&[&good, "-o", "/proc/limpid"]), 1, &["/proc/limpid"]);
    fails(&points(&["testdata/room.mcap"]), 1, &["testdata/room.mcap", "no point cloud"]);
    fails(&points(&["testdata/room.mcap", "--topic", "/x"]), 2, &["`topic`", "`/x`"]);
}

#[test]
fn packets_on_another_port_are_named_and_taken_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let frames: Vec<Vec<u8>> = turning(160, VLP16).iter().map(|packet| frame(2370, packet)).collect();
    let input = file(folder.path(), "drive.pcap", &capture(&frames));
    fails(&points(&[&input]), 1, &["UDP port 2368", "port 2370 (160)", "--port 2370", "velodyne_port"]);
    let output = points(&[&input, "--port", "2370"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && text.contains("3 scans, 61440 points"), "{text}");
    let ouster = file(folder.path(), "ouster.pcap", &capture(&[frame(7502, &[0; 6464])]));
    fails(&points(&[&ouster]), 1, &["port 7502", "Ouster", "not decoded"]);
}

#[test]
fn packets_of_other_velodyne_sensors_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for (flags, byte, sensor) in
        [([0xee, 0xdd], 0x02, "HDL-64E"), ([0xee, 0xdd], 0xa1, "VLS-128"), ([0xcc, 0xbb], 0x00, "VLS-128")]
    {
        let mut packets = turning(20, VLP16);
        for packet in &mut packets {
            packet[..1200].chunks_mut(100).enumerate().for_each(|(at, block)| block[1] = flags[at % 2]);
            packet[1205] = byte;
        }
        let input = file(folder.path(), "other.pcap", &capture_packets(&packets));
        let output = points(&[&input]);
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(!output.status.success() && text.contains(sensor) && text.contains("not decoded"), "{text}");
        assert!(text.contains("VLP-16, Puck Hi-Res, HDL-32E and VLP-32C are"), "{text}");
    }
}
