//! Real recordings against the figures of other programs (tests/reference/velodyne.py, stored in testdata/reference).

use limpid::input::points::{Options, ScanReport};
use limpid::sensor::{ReturnType, Scan};
use serde_json::Value;

use super::read_all;
use crate::support::data_dir;

/// Mean distance between limpid's and the peer's coordinates: its table of the HDL-32E's vertical offsets is rounded.
const MEAN_TOLERANCE_M: f64 = 1e-4;

fn reference(recording: &str) -> Value {
    let text = std::fs::read_to_string("testdata/reference/lidar_points.json").unwrap();
    let figures = serde_json::from_str::<Value>(&text).unwrap()[recording].take();
    assert!(figures.is_object(), "no figures of {recording}");
    figures
}

/// What of the scans is not as the figures say.
fn difference(scans: &[Scan], expected: &Value) -> Option<String> {
    let points = || scans.iter().flat_map(|scan| &scan.points);
    let count = points().count();
    if count == 0 || count as u64 != expected["points"].as_u64().unwrap() {
        return Some(format!("{count} points in place of {}", expected["points"]));
    }
    let sum = |value: &dyn Fn(usize) -> f64| (1..).zip(0..count).map(|(_, at)| value(at)).sum::<f64>();
    let all: Vec<_> = points().collect();
    for axis in 0..3 {
        let found = [
            sum(&|at| f64::from(all[at].position_m()[axis])),
            sum(&|at| f64::from(all[at].position_m()[axis]).abs()),
        ];
        for (key, found) in ["sum_m", "sum_abs_m"].into_iter().zip(found) {
            let apart_m = (found - expected[key][axis].as_f64().unwrap()).abs() / count as f64;
            if apart_m.is_nan() || apart_m > MEAN_TOLERANCE_M {
                return Some(format!("axis {axis}: {key} is {apart_m} m a point off"));
            }
        }
    }
    let weighed =
        |value: &dyn Fn(usize) -> u64| (1..).zip(0..count).map(|(n, at)| n % 1009 * value(at)).sum::<u64>();
    let sums = [
        ("intensity", weighed(&|at| all[at].intensity as u64)),
        ("ring", weighed(&|at| all[at].ring.into())),
        ("return_type", weighed(&|at| all[at].return_type as u64)),
    ];
    let wrong = sums.into_iter().find(|(key, sum)| expected[key].as_u64() != Some(*sum));
    wrong.map(|(key, sum)| format!("checksum of {key} is {sum}"))
}

#[track_caller]
fn assert_figures(folder: &str, name: &str, scans: usize) -> Option<(Vec<Scan>, ScanReport)> {
    let path = data_dir(&format!("lidar/{folder}{name}"))?;
    let (found, report) = read_all(&path, &Options::default()).unwrap();
    assert_eq!(difference(&found, &reference(name)), None, "{name}");
    assert_eq!(found.len(), scans, "{name}");
    Some((found, report))
}

#[test]
fn hdl32e_captures_have_the_peers_points() {
    assert_figures("mrpt-velodyne-strongest/", "sample_velodyne_hdl32.pcap", 4);
    let monterey = assert_figures("veloview-hdl32e-vlp16-strongest/", "monterey-first-100-packets.pcap", 19);
    let Some((scans, report)) = monterey else { return };
    assert!(report.read.notes.is_empty(), "{report:?}");
    assert_eq!(report.read.skipped[0].reason, "position packet (UDP port 8308)");
    // Whole turns of about 12 a second.
    for pair in scans[1..18].windows(2) {
        let turn_ms = (pair[1].stamp_ns - pair[0].stamp_ns) / 1_000_000;
        assert!((75..90).contains(&turn_ms), "{turn_ms} ms");
    }
}

#[test]
fn vlp16_captures_have_the_peers_points_whatever_their_factory_byte() {
    let Some((_, gps)) = assert_figures("mrpt-velodyne-strongest/", "sample_velodyne_vlp16_gps.pcap", 5)
    else {
        return;
    };
    assert!(gps.read.notes.is_empty(), "{gps:?}");
    let quirk = "vlp-16-test-90deg-1-50-frames.pcap";
    let (_, report) = assert_figures("veloview-hdl32e-vlp16-strongest/", quirk, 52).unwrap();
    assert!(
        report.read.notes[0].contains("says HDL-32E") && report.read.notes[0].contains("VLP-16"),
        "{report:?}"
    );
}

#[test]
fn dual_packets_have_the_peers_points_and_slots() {
    let Some((scans, _)) = assert_figures("", "vlp16-dual.mcap", 4) else { return };
    for scan in &scans {
        // Of the recording: about 160 beams a revolution have two returns, and the last is the farther.
        let of = |slot: ReturnType| scan.points.iter().filter(move |point| point.return_type == slot);
        assert!(of(ReturnType::Last).count() > 250 && of(ReturnType::StrongestOrSecond).count() > 150);
        let range = |p: &limpid::sensor::Point| p.position_m().map(|m| m * m).iter().sum::<f32>();
        let pairs: Vec<_> = scan
            .points
            .windows(2)
            .filter(|pair| {
                pair[0].return_type == ReturnType::Last
                    && pair[1].return_type == ReturnType::StrongestOrSecond
            })
            .filter(|pair| (pair[0].ring, pair[0].column) == (pair[1].ring, pair[1].column))
            .collect();
        assert!(pairs.len() > 150, "{} pairs", pairs.len());
        assert!(pairs.iter().all(|pair| range(&pair[0]) > range(&pair[1])));
    }
}

#[test]
fn clouds_and_ply_files_of_one_recording_agree() {
    let Some((clouds, report)) = assert_figures("", "3dref.mcap", 6) else { return };
    assert!(report.read.skipped.is_empty() && report.dropped.total() == 0, "{report:?}");
    let (files, _) =
        read_all(&data_dir("lidar/3dref-hesai-qt64-dual").unwrap(), &Options::default()).unwrap();
    assert_eq!(files.len(), 6);
    for (cloud, file) in clouds.iter().zip(&files) {
        assert_eq!(cloud.stamp_ns / 1_000_000, file.stamp_ns / 1_000_000);
        assert_eq!(cloud.points.len(), file.points.len());
        assert!(file.columns.label && !cloud.columns.label);
        for (a, b) in cloud.points.iter().zip(&file.points) {
            assert_eq!((a.intensity, a.ring, a.return_type), (b.intensity, b.ring, b.return_type));
            assert!(
                a.position_m().iter().zip(b.position_m()).all(|(a, b)| (a - b).abs() < 1e-5),
                "{a:?} {b:?}"
            );
        }
    }
    // SOURCE.txt there: about 1,080 points on glass, label 2.
    let glass = files[0].points.iter().filter(|point| point.label == 2).count();
    assert!((1000..1160).contains(&glass), "{glass}");
}

#[test]
fn a_binary_ply_of_another_sensor_is_read() {
    let folder = "lidar/rellis3d-os1-64-labelled";
    let Some(path) = data_dir(&format!("{folder}/frame000104-1581624663_170.ply")) else { return };
    let (scans, report) = read_all(&path, &Options::default()).unwrap();
    // SOURCE.txt there: 131,072 beams, 77,708 with a return.
    assert_eq!((scans[0].points.len(), report.dropped.total()), (77_708, 131_072 - 77_708));
    let last_s = scans[0].points.iter().map(|point| point.time_s).fold(0.0, f32::max);
    assert!((0.09..0.101).contains(&last_s), "nanoseconds of a tenth of a second: {last_s}");
    assert!(scans[0].points.iter().all(|point| point.ring < 64));
}

#[test]
fn recordings_without_points_of_use_are_refused() {
    let Some(ouster) = data_dir("lidar/ouster-os0-32-dual/OS-0-32-U1_v2.2.0_1024x10.pcap") else { return };
    super::refused(read_all(&ouster, &Options::default()), &["no Velodyne data packets", "UDP on port 7502"]);
    let pcd = data_dir("lidar/nebula-hesai-qt64-dual/1673401196087570870.pcd").unwrap();
    let (scans, _) = read_all(&pcd, &Options::default()).unwrap();
    // SOURCE.txt there: x, y, z alone.
    assert!(scans[0].points.len() == 34_158 && !scans[0].columns.intensity);
}

#[test]
fn the_comparison_with_the_peer_can_fail() {
    let Some(path) = data_dir("lidar/vlp16-dual.mcap") else { return };
    let (scans, _) = read_all(&path, &Options::default()).unwrap();
    let expected = reference("vlp16-dual.mcap");
    let with = |change: &dyn Fn(&mut Scan)| {
        let mut changed = scans.clone();
        change(&mut changed[1]);
        difference(&changed, &expected)
    };
    assert_eq!(with(&|_| ()), None);
    assert!(with(&|scan| scan.points.truncate(9)).unwrap().contains("points"));
    assert!(with(&|scan| scan.points[5].ring += 1).unwrap().contains("ring"));
    assert!(with(&|scan| scan.points[5].intensity += 1.0).unwrap().contains("intensity"));
    assert!(with(&|scan| scan.points.swap(0, 2000)).is_some());
    assert!(
        with(&|scan| scan.points.iter_mut().for_each(|point| point.z_m += 0.001)).unwrap().contains("axis 2")
    );
    assert!(with(&|scan| scan.points[5].x_m = f32::NAN).unwrap().contains("axis 0"));
    assert!(difference(&[], &expected).is_some());
}
