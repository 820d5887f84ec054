//! `limpid info RECORDING`: what it holds and what a run would use, without running anything.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::Value;

use crate::cli::{ROOM, fails, limpid, succeeds};
use crate::read::synthetic::{DEPTH, FRAME, Recorder, at_ms};
use crate::support::data_dir;
use crate::support::gpu::skipped;

/// The command on a machine without any adapter.
fn info(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
    command.arg("info").args(arguments).current_dir(env!("CARGO_MANIFEST_DIR"));
    command.env("VK_DRIVER_FILES", "/nonexistent.json").env("VK_ICD_FILENAMES", "/nonexistent.json");
    command.output().unwrap()
}

#[track_caller]
fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&succeeds(&info(&[arguments, &["--json"]].concat()))).unwrap()
}

fn topic<'a>(report: &'a Value, name: &str) -> &'a Value {
    report["topics"].as_array().unwrap().iter().find(|topic| topic["topic"] == name).unwrap()
}

#[test]
fn a_recording_is_told_without_an_adapter() {
    let text = succeeds(&info(&[ROOM]));
    for part in
        ["MCAP", "/tf", "tf2_msgs/msg/TFMessage", "poses", "Hz", "map -> ", "would use", "camera", "method "]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!text.contains("missing:"), "{text}");
    let report = json(&[ROOM]);
    let depth =
        report["topics"].as_array().unwrap().iter().find(|topic| {
            report["uses"][topic["topic"].as_str().unwrap()][0].as_str() == Some("camera: depth")
        });
    let depth = depth.unwrap();
    // Thirty frames in three seconds.
    assert_eq!(depth["messages"], 30);
    assert!((depth["rate_hz"].as_f64().unwrap() - 10.0).abs() < 1.5, "{depth}");
    assert_eq!(report["sensors"][0]["kind"], "camera");
    assert!(report["sensors"][0]["with_pose"].as_u64().unwrap() > 0);
    assert_eq!(report["size_bytes"], std::fs::metadata(ROOM).unwrap().len());
}

#[test]
fn what_it_says_is_used_is_what_a_run_uses() {
    if skipped() {
        return;
    }
    let told = succeeds(&info(&[ROOM]));
    let run = succeeds(&limpid(&["run", ROOM, "--frames", "0..2"]));
    let choices = run.lines().filter(|line| line.starts_with("note: topics:"));
    assert_eq!(choices.filter(|line| told.lines().any(|own| own == *line)).count(), 1, "{run}\n{told}");
}

#[test]
fn a_cut_recording_is_counted_and_its_damage_told() {
    let whole = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join(ROOM)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let cut = folder.path().join("cut.mcap");
    std::fs::write(&cut, &whole[..whole.len() * 2 / 3]).unwrap();
    let name = cut.to_str().unwrap();
    let text = succeeds(&info(&[name]));
    assert!(text.contains("cut off or damaged"), "{text}");
    let (part, all) = (json(&[name]), json(&[ROOM]));
    for of_all in all["topics"].as_array().unwrap() {
        let counted = topic(&part, of_all["topic"].as_str().unwrap())["messages"].as_u64().unwrap();
        let most = of_all["messages"].as_u64().unwrap();
        assert!(counted <= most && (counted > 0 || most < 3), "{of_all}: {counted}");
    }
    assert!(part["duration_s"].as_f64().unwrap() < all["duration_s"].as_f64().unwrap());
}

#[test]
fn what_is_missing_is_told_with_its_key() {
    let mut recorder = Recorder::new();
    for ms in 0..30 {
        recorder.transform("/tf", at_ms(100 * ms), ["odom", FRAME], [0.0; 3], [0.0, 0.0, 0.0, 1.0]);
        recorder.depth(at_ms(100 * ms), 1000);
        recorder.bytes("/noise", "sensor_msgs/msg/Joy", "cdr", at_ms(100 * ms), &[0; 8]);
    }
    let saved = recorder.save();
    let name = saved.path.to_str().unwrap();
    let text = succeeds(&info(&[name]));
    assert!(text.contains("missing: ") && text.contains("set map_frame: odom"), "{text}");
    assert!(
        text.lines().any(|line| line.starts_with("/noise") && line.ends_with("(type not read)")),
        "{text}"
    );
    let report = json(&[name]);
    assert_eq!(report["uses"][DEPTH][0], "camera: depth");
    assert_eq!(topic(&report, "/noise")["messages"], 30);
    assert!((topic(&report, "/noise")["rate_hz"].as_f64().unwrap() - 10.0).abs() < 1e-6);
    assert_eq!(report["sensors"][0]["with_pose"], 0);
}

#[test]
fn a_recording_of_which_nothing_can_be_used_is_told_all_the_same() {
    let mut recorder = Recorder::new();
    recorder.bytes("/noise", "sensor_msgs/msg/Joy", "cdr", at_ms(0), &[0; 8]);
    let saved = recorder.save();
    let output = info(&[saved.path.to_str().unwrap()]);
    fails(&output, 1, &["depth"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("/noise") && text.contains("  nothing"), "{text}");
}

#[test]
fn wrong_usage_and_missing_files_are_named() {
    fails(&info(&["no/such.mcap"]), 1, &["no/such.mcap"]);
    fails(&info(&["--json"]), 2, &["RECORDING"]);
    fails(&info(&[ROOM, "-c", "no-such.yaml"]), 2, &["no-such.yaml"]);
    fails(&info(&["Cargo.toml"]), 1, &["Cargo.toml", "MCAP"]);
}

#[test]
fn real_recordings_are_told() {
    for (path, parts) in [
        ("rgbd/kitchen.mcap", ["camera: depth", "map -> base_link -> camera_color_optical_frame"].as_slice()),
        ("rgbd/kitchen-tum", &["TUM RGB-D folder", "640x480"]),
        ("rgbd/librealsense-d435-bag", &[]),
        ("lidar/3dref.mcap", &["lidar: scans", "points in the first scan"]),
        ("lidar/vlp16-dual.mcap", &["velodyne_msgs/msg/VelodyneScan", "rings up to 15"]),
        ("field/no-tf/in.bag", &["ROS 1 bag", "missing: ", "static_transforms"]),
        ("field/odom-base_footprint/in.mcap", &["missing: ", "map_frame: odom"]),
    ] {
        let Some(mut path) = data_dir(path) else { continue };
        if path.ends_with("librealsense-d435-bag") {
            let mut files = std::fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path());
            path = files.find(|file| file.extension().is_some_and(|extension| extension == "bag")).unwrap();
        }
        let text = succeeds(&info(&[path.to_str().unwrap()]));
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    }
}

#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_ends_it_quietly() {
    use std::io::Read;
    use std::process::Stdio;
    let mut command = Command::new(env!("CARGO_BIN_EXE_limpid"));
    command.args(["info", ROOM]).current_dir(env!("CARGO_MANIFEST_DIR"));
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let mut said = String::new();
    child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
    assert!(child.wait().unwrap().success() && said.is_empty(), "{said}");
}
