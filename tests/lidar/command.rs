//! `limpid run` and `limpid score` on lidar recordings.

use std::process::Command;

use limpid::output::save_scan;
use limpid::sensor::{Columns, Point, Scan};

use crate::support::gpu::skipped;
use crate::support::scan::{point, scan};

/// A ring of dim posts with a bright one ahead, twice.
fn recording(folder: &std::path::Path) {
    let mut points: Vec<Point> = (0..90)
        .map(|i| {
            let angle = f64::from(i) * 4.0_f64.to_radians();
            point([4.0 * angle.cos(), 4.0 * angle.sin(), 0.1], 30.0)
        })
        .collect();
    points.extend(vec![point([3.05, 0.05, 0.1], 250.0); 5]);
    // Files have rings; of one ring there are no planes, so slabs are taken.
    points.iter_mut().for_each(|point| point.ring = 0);
    let scan = Scan { columns: Columns::default(), ..scan(0, points) };
    save_scan(&folder.join("1700000000.000.ply"), &scan).unwrap();
    save_scan(&folder.join("1700000000.100.ply"), &scan).unwrap();
}

/// A configuration that takes the few intensities as they are.
fn by_intensity(folder: &std::path::Path) -> String {
    let path = folder.join("limpid.yaml");
    std::fs::write(&path, "solidity: intensity\n").unwrap();
    path.to_string_lossy().into_owned()
}

/// Two maps on every topic, and no transforms.
fn holds_maps(mcap: &str) {
    let bytes = std::fs::read(mcap).unwrap();
    let messages: Vec<_> = ::mcap::MessageStream::new(&bytes).unwrap().map(|m| m.unwrap()).collect();
    for topic in ["/limpid/costmap", "/limpid/costmap_raw", "/limpid/classes"] {
        assert_eq!(messages.iter().filter(|m| m.channel.topic == topic).count(), 2, "{topic}");
    }
    assert!(messages.iter().all(|m| m.channel.topic != "/tf"), "there are no poses to write");
    assert_eq!(messages[0].log_time, 1_700_000_000_000_000_000);
}

fn limpid(arguments: &[&str]) -> (bool, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_limpid")).args(arguments).output().unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8_lossy(&text).into_owned())
}

#[test]
fn run_writes_plan_maps_in_every_form() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    std::fs::create_dir(path("scans")).unwrap();
    recording(&folder.path().join("scans"));
    let (mcap, png, dump, map) = (path("out.mcap"), path("png"), path("dump"), path("map"));
    let config = by_intensity(folder.path());
    let line = format!("run {} -c {config} -o {mcap} --png {png} --dump {dump} --map {map}", path("scans"));
    let (done, text) = limpid(&line.split(' ').collect::<Vec<_>>());
    assert!(done && text.contains("lidar: 2 used") && text.contains("1 solid"), "{text}");
    let names = |folder: &str| {
        let entries =
            std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<_> = entries.collect();
        names.sort();
        names
    };
    assert_eq!(names(&png), ["000000-map.png", "000001-map.png"]);
    let expected = [
        "age_s.exr",
        "class.exr",
        "cost.exr",
        "costmap.exr",
        "false_negative.exr",
        "false_positive.exr",
        "frame.json",
        "inflated.exr",
        "intensity_0.exr",
        "intensity_1.exr",
        "intensity_below.exr",
        "intensity_plane.exr",
        "plan.exr",
        "reason.exr",
        "sensor.exr",
        "true_positive.exr",
    ];
    assert_eq!(names(&format!("{dump}/000001")), expected);
    let json: serde_json::Value =
        serde_json::from_slice(&std::fs::read(format!("{dump}/000001/frame.json")).unwrap()).unwrap();
    assert_eq!((json["points"].as_u64(), json["cells"]["solid"].as_u64()), (Some(95), Some(1)));
    assert!(std::fs::metadata(format!("{map}.pgm")).unwrap().len() > 40_000);
    holds_maps(&mcap);
}

#[test]
fn score_lists_candidates_with_the_cheapest_first() {
    if skipped() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    recording(folder.path());
    let input = folder.path().to_string_lossy().into_owned();
    let (done, text) =
        limpid(&["score", &input, "--v", "1,1,1", "--omega", "-0.5,0.5,3", "--horizon", "2.9", "--json"]);
    let scores: serde_json::Value = serde_json::from_str(text.trim()).unwrap();
    let worst = |at: usize| scores[at]["score"]["worst"].as_u64().unwrap();
    assert!(
        done && worst(1) >= 253 && worst(0) < 253 && worst(2) < 253,
        "straight on it meets the post: {text}"
    );
    assert!(!limpid(&["score", &input, "--v", "fast"]).0);
    let (done, text) = limpid(&["score", &input, "--scan", "7"]);
    assert!(!done && text.contains("scan 7 was not mapped; the last before it that was is 1"), "{text}");
}

#[test]
fn camera_recordings_have_no_scans_and_say_so() {
    let room = concat!(env!("CARGO_MANIFEST_DIR"), "/testdata/room.mcap");
    let (done, text) = limpid(&["run", room, "--sensor", "lidar"]);
    assert!(!done && text.contains("point cloud, laser scan or Velodyne packets"), "{text}");
}
