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
